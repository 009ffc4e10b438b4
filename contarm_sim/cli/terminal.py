"""What people see: tables on stdout, progress and messages on stderr."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from contarm_sim.model.arm import Arm


def command_line() -> str:
    """Return the command as it was typed."""
    return shlex.join(["contarm", *sys.argv[1:]])


def say(message: str) -> None:
    """Print a message to stderr, if anybody is there: the terminal may have been closed."""
    if sys.stderr is None:  # or `print` would write to stdout
        return
    with suppress(OSError, ValueError):
        print(message, file=sys.stderr, flush=True)


def say_objects(arm: Arm, instead: str = "") -> None:
    """Say that objects are not looked at, where there are any and closed forms know nothing of them.

    Args:
        instead: what looks at them.
    """
    if arm.world.touchable:
        names = ", ".join(each.name for each in arm.world.objects) or "self-contact"
        if arm.world.host is not None:
            names = f"the world {Path(arm.world.host.file).name}"
        say(f"not looked at: {names}; closed forms know nothing that the arm can touch{instead and '; ' + instead}")


EVERY = 10.0
"""Time between lines of progress where stderr is no terminal [s]."""


def track(steps: Iterable[int], what: str) -> Iterator[int]:
    """Yield the steps behind a progress bar on stderr, see `progress`."""
    given = list(steps)
    with progress(what) as show:
        for done, step in enumerate(given):
            show(done, len(given))
            yield step


@contextmanager
def progress(what: str, words: Callable[[int, int], str] | None = None) -> Iterator[Callable[[int, int], None]]:
    """Yield a function of (done, total) that shows progress on stderr: a bar; lines now and then if it is no terminal.

    Args:
        what: is done.
        words: say how far it is, in place of counts and of a guess of the time left.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    console = Console(stderr=True)
    if not console.is_terminal:  # a disabled bar of an older rich would still end in an empty line
        yield _lines(what, words or "{} of {}".format)
        return
    columns: Any = Progress.get_default_columns()
    if words is not None:
        columns = TextColumn(what), BarColumn(), TextColumn("{task.fields[said]}")
    bar = Progress(*columns, console=console, transient=True)
    task = bar.add_task(what, total=None, said="")

    def show(done: int, total: int) -> None:
        bar.update(task, completed=done, total=total, said=words(done, total) if words is not None else "")

    with suppress(OSError):  # a terminal that is closed costs no work
        bar.start()
    try:
        yield show
    finally:
        with suppress(OSError):
            bar.stop()


def _lines(what: str, words: Callable[[int, int], str]) -> Callable[[int, int], None]:
    """Return a function of (done, total) that says so on stderr, at most every `EVERY` seconds."""
    last = time.monotonic()

    def show(done: int, total: int) -> None:
        nonlocal last
        said = words(done, total)
        if time.monotonic() - last >= EVERY:
            last = time.monotonic()
            say(f"{what}: {said}")

    return show


def width() -> int:
    """Return how many characters a line on stdout takes: 120 where that is no terminal."""
    from rich.console import Console

    console = Console()
    return console.width if console.is_terminal else 120


def table(title: str, columns: list[str], rows: list[list[Any]], caption: str | None = None) -> None:
    """Print a table to stdout; numbers are aligned right."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.markup import escape  # or it would take [mm] for markup
    from rich.table import Table

    made = Table(
        title=escape(title),
        caption=caption,
        box=SIMPLE_HEAD,
        title_justify="left",
        caption_justify="left",
        pad_edge=False,
    )
    for index, column in enumerate(columns):
        made.add_column(escape(column), justify="left" if index == 0 else "right", overflow="fold")
    for row in rows:
        made.add_row(*(escape(value) if isinstance(value, str) else f"{value:.4g}" for value in row))
    console = Console(width=width())
    with console.capture() as drawn:
        console.print(made)
    click.echo(drawn.get(), nl=False)  # rich would end the process by itself where nobody reads

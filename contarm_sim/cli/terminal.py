"""What people see: tables on stdout, progress and messages on stderr."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import click


def command_line() -> str:
    """Return the command as it was typed."""
    return shlex.join(["contarm", *sys.argv[1:]])


def say(message: str) -> None:
    """Print a message to stderr, if anybody is there: the terminal may have been closed."""
    if sys.stderr is None:  # or `print` would write to stdout
        return
    with suppress(OSError, ValueError):
        print(message, file=sys.stderr, flush=True)


def track(steps: Iterable[int], what: str) -> Iterator[int]:
    """Yield the steps behind a progress bar on stderr; silent where stderr is no terminal."""
    from rich.console import Console
    from rich.progress import track as rich_track

    console = Console(stderr=True)
    if not console.is_terminal:
        return iter(steps)
    return iter(rich_track(list(steps), what, console=console, transient=True))


@contextmanager
def progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """Yield a function of (done, total) that shows progress on stderr; silent where stderr is no terminal."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    if not console.is_terminal:  # a disabled bar of an older rich would still end in an empty line
        yield lambda done, total: None
        return
    bar = Progress(console=console, transient=True)
    task = bar.add_task(what, total=None)

    def show(done: int, total: int) -> None:
        if done % max(1, total // 100) == 0:
            bar.update(task, completed=done, total=total)

    with suppress(OSError):  # a terminal that is closed costs no work
        bar.start()
    try:
        yield show
    finally:
        with suppress(OSError):
            bar.stop()


def table(title: str, columns: list[str], rows: list[list[Any]], caption: str | None = None) -> None:
    """Print a table to stdout; numbers are aligned right."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.markup import escape  # or it would take [mm] for markup
    from rich.table import Table

    made = Table(
        title=title, caption=caption, box=SIMPLE_HEAD, title_justify="left", caption_justify="left", pad_edge=False
    )
    for index, column in enumerate(columns):
        made.add_column(escape(column), justify="left" if index == 0 else "right", overflow="fold")
    for row in rows:
        made.add_row(*(escape(value) if isinstance(value, str) else f"{value:.4g}" for value in row))
    console = Console()
    console = Console(width=console.width if console.is_terminal else 120)
    with console.capture() as drawn:
        console.print(made)
    click.echo(drawn.get(), nl=False)  # rich would end the process by itself where nobody reads

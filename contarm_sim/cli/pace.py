"""Progress of many cases: how many are done, how fast, and how long the rest takes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from contarm_sim.cli.terminal import EVERY, say

Show = Callable[[int, int], None]


@contextmanager
def pace(what: str) -> Iterator[Show]:
    """Yield a function of (cases done, of all) that shows progress on stderr; the first call counts as the start."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    console, said = Console(stderr=True), _Said()
    if not console.is_terminal:
        yield _lines(what, said)
        return
    bar = Progress(TextColumn(what), BarColumn(), TextColumn("{task.fields[said]}"), console=console, transient=True)
    task = bar.add_task(what, total=None, said="")

    def show(done: int, total: int) -> None:
        bar.update(task, completed=done, total=total, said=said(done, total))

    with suppress(OSError):  # a terminal that is closed costs no work
        bar.start()
    try:
        yield show
    finally:
        with suppress(OSError):
            bar.stop()


class _Said:
    """Says how far it is; the rate is that since the first call."""

    def __init__(self) -> None:
        self._first: tuple[float, int] | None = None

    def __call__(self, done: int, total: int) -> str:
        now = time.monotonic()
        if self._first is None:
            self._first = now, done
        spent, since = now - self._first[0], done - self._first[1]
        text = f"{done:,} of {total:,} cases"
        if since <= 0 or spent <= 0:
            return text
        return f"{text}, {rate(since / spent)}, {duration((total - done) * spent / since)} left"


def _lines(what: str, said: _Said) -> Show:
    last = time.monotonic()

    def show(done: int, total: int) -> None:
        nonlocal last
        text = said(done, total)
        if time.monotonic() - last >= EVERY:
            last = time.monotonic()
            say(f"{what}: {text}")

    return show


def rate(a_second: float) -> str:
    """Return a number of cases by time in words."""
    return f"{a_second:,.3g} a second" if a_second >= 1 else f"{60 * a_second:.2g} a minute"


def duration(seconds: float) -> str:
    """Return a time in words, in its two largest units."""
    whole = round(seconds)
    for unit, size, less, small in (("d", 86400, "h", 3600), ("h", 3600, "min", 60), ("min", 60, "s", 1)):
        if whole >= size:
            return f"{whole // size} {unit} {whole % size // small} {less}"
    return f"{whole} s"

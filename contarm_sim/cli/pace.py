"""Progress of many cases: how many are done, how fast, and how long the rest takes."""

from __future__ import annotations

import time
from contextlib import AbstractContextManager
from typing import Any

from contarm_sim.cli.terminal import progress

SETTLED = 3.0
"""Time from the second call on after which a rate is told [s]: what is done first makes models for the rest too."""


def pace(what: str) -> AbstractContextManager[Any]:
    """Return a context of a function of (cases done, of all) that shows progress; the first call is the start."""
    return progress(what, _Said())


class _Said:
    """Says how far it is; the rate is that since the first call by which something was done."""

    def __init__(self) -> None:
        self._start: int | None = None
        self._first: tuple[float, int] | None = None

    def __call__(self, done: int, total: int) -> str:
        now, text = time.monotonic(), f"{done:,} of {total:,} cases"
        self._start = done if self._start is None else self._start
        if self._first is None:
            self._first = (now, done) if done > self._start else None
            return text
        spent, since = now - self._first[0], done - self._first[1]
        if since <= 0 or spent < SETTLED:
            return text
        return f"{text}, {rate(since / spent)}, {duration((total - done) * spent / since)} left"


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

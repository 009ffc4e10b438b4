"""How many threads there are for arms, and work that is shared by them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

from contarm_sim.processors import processors

ARMS_A_THREAD = 4
"""Fewest arms that a thread is for: to wake it costs as much as a step of one."""

_most: ContextVar[int] = ContextVar("most", default=0)

T = TypeVar("T")
R = TypeVar("R")


def thread_count(arms: int, threads: int = 0) -> int:
    """Return how many of the threads given (0: one a processor) step so many arms."""
    return max(1, min(allowed(threads), arms // ARMS_A_THREAD))


def allowed(threads: int = 0) -> int:
    """Return how many threads there may be where so many are asked for; 0: one a processor."""
    asked, most = threads or processors(), _most.get()
    return min(asked, most) if most else asked


@contextmanager
def at_most(threads: int) -> Iterator[None]:
    """Let all that runs inside have so many threads at most; 0: as many as outside."""
    token = _most.set(allowed(threads) if threads else _most.get())
    try:
        yield
    finally:
        _most.reset(token)


@contextmanager
def pool(threads: int) -> Iterator[ThreadPoolExecutor]:
    """Give threads that leave undone what is not begun where an error, or Ctrl-C, ends the block."""
    made = ThreadPoolExecutor(threads)
    try:
        yield made
    finally:
        made.shutdown(cancel_futures=True)


def shared_out(function: Callable[[T], R], tasks: Sequence[T], threads: int = 0) -> list[R]:
    """Return what a function makes of each task, on the threads that there may be; of one alone, on this."""
    count = min(allowed(threads), len(tasks))
    if count <= 1:
        return [function(task) for task in tasks]
    with pool(count) as some:
        return list(some.map(function, tasks))

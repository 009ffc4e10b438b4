"""How many threads step arms."""

from __future__ import annotations

import os

ARMS_A_THREAD = 4
"""Fewest arms that a thread is for: to wake it costs as much as a step of one."""


def thread_count(arms: int, threads: int = 0) -> int:
    """Return how many of the threads given (0: one a processor) step so many arms."""
    return max(1, min(threads or processors(), arms // ARMS_A_THREAD))


def processors() -> int:
    """Return how many processors there are for this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

"""How a study shows that it goes on: it hands the numbers of its steps to a function that yields them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

Track = Callable[[Iterable[int], str], Iterable[int]]
"""Takes the numbers of steps, and what they are, and yields them: a progress bar."""


def quietly(steps: Iterable[int], what: str) -> Iterable[int]:
    """Return the steps: a progress bar that shows nothing."""
    return steps

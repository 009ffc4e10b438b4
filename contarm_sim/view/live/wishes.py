"""What people ask of the page, kept until the loop has time for it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Any


class Wishes:
    """Actions to be carried out between two ticks; of one that is asked for many times, only the last."""

    def __init__(self) -> None:
        self._waiting: dict[Callable[..., None], Callable[[], None]] = {}
        self._lock = threading.Lock()

    def put(self, action: Callable[..., None], *values: Any) -> None:
        """Ask for an action on values, instead of the same action on others; from any thread."""
        with self._lock:
            self._waiting.pop(action, None)
            self._waiting[action] = partial(action, *values)

    def take(self) -> list[Callable[[], None]]:
        """Return what is to be done, in the order in which it was last asked for."""
        with self._lock:
            waiting, self._waiting = self._waiting, {}
        return list(waiting.values())

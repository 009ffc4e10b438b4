"""Where simulations run: without log files, and with one BLAS thread."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from threading import Lock

import mujoco
from threadpoolctl import ThreadpoolController


class _Shared:
    """What threads share while any of them is inside: entered by the first, left by the last."""

    def __init__(self, enter: Callable[[], Callable[[], None]]) -> None:
        self._enter, self._lock, self._inside = enter, Lock(), 0

    @contextmanager
    def __call__(self) -> Iterator[None]:
        with self._lock:
            self._inside += 1
            if self._inside == 1:
                self._leave = self._enter()
        try:
            yield
        finally:
            with self._lock:
                self._inside -= 1
                if self._inside == 0:
                    self._leave()


def _one_thread() -> Callable[[], None]:
    limited = _libraries("scipy.linalg" in sys.modules).limit(limits=1, user_api="blas")
    return limited.restore_original_limits


def _silence() -> Callable[[], None]:
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_ignore)
    return lambda: mujoco.set_mju_user_warning(previous)


_threads, _silent = _Shared(_one_thread), _Shared(_silence)


@contextmanager
def engine_room() -> Iterator[None]:
    """Run simulations inside: no warnings written to MUJOCO_LOG.TXT, no BLAS threads.

    `Plant.check` reads the engine's warning counters instead. The matrices here are small: a second BLAS thread gains
    nothing, and spins beside the stepping loop until that takes twice as long.
    """
    with _silent(), _threads():
        yield


@lru_cache
def _libraries(scipy: bool) -> ThreadpoolController:
    """Return what limits the BLAS libraries that are loaded; to look for them takes a millisecond."""
    return ThreadpoolController()


@contextmanager
def quiet_engine() -> Iterator[None]:
    """Keep the engine from writing warnings to MUJOCO_LOG.TXT; its counters still tell."""
    with _silent():
        yield


def _ignore(message: str) -> None:
    pass

"""Where simulations run: without log files, and with one BLAS thread."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

import mujoco
from threadpoolctl import ThreadpoolController


@contextmanager
def engine_room() -> Iterator[None]:
    """Run simulations inside: no warnings written to MUJOCO_LOG.TXT, no BLAS threads.

    `Plant.check` reads the engine's warning counters instead. The matrices here are small: a second BLAS thread gains
    nothing, and spins beside the stepping loop until that takes twice as long.
    """
    with quiet_engine(), _libraries("scipy.linalg" in sys.modules).limit(limits=1, user_api="blas"):
        yield


@lru_cache
def _libraries(scipy: bool) -> ThreadpoolController:
    """Return what limits the BLAS libraries that are loaded; to look for them takes a millisecond."""
    return ThreadpoolController()


@contextmanager
def quiet_engine() -> Iterator[None]:
    """Keep the engine from writing warnings to MUJOCO_LOG.TXT; its counters still tell."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_ignore)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)


def _ignore(message: str) -> None:
    pass

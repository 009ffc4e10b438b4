"""What simulates many arms at once, by name; importing this loads none of it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal, get_args

from contarm_sim.errors import InputError

if TYPE_CHECKING:
    from contarm_sim.engine.plant import Plant
    from contarm_sim.engine.plants import Plants

BackendName = Literal["cpu"]  # what type checkers know

BACKENDS: tuple[BackendName, ...] = get_args(BackendName)
"""`cpu`: the engine itself, on threads, to the bits of one arm alone."""

_HOMES: dict[str, str] = {"cpu": "plants:Plants"}
"""Classes with the interface of `engine.plants.Plants`."""


def check_backend(name: str) -> None:
    """Refuse what is no backend.

    Raises:
        InputError: lists those that there are.
    """
    if name not in BACKENDS:
        raise InputError("backend", repr(name), ", ".join(BACKENDS))


def together(plants: Sequence[Plant], threads: int = 0, backend: str = "cpu") -> Plants:
    """Return arms of one layout, stepped together from where they are, see `Plants.of`.

    Raises:
        InputError: an unknown backend.
    """
    check_backend(backend)
    module, kind = _HOMES[backend].split(":")
    found: Any = getattr(import_module(f"contarm_sim.engine.{module}"), kind)
    made: Plants = found.of(plants, threads)
    return made

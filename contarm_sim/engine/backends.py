"""What simulates many arms at once, by name; importing this loads none of it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal, get_args

from contarm_sim.errors import InputError

if TYPE_CHECKING:
    from contarm_sim.engine.plant import Plant
    from contarm_sim.engine.plants import Plants

BackendName = Literal["cpu", "warp"]  # what type checkers know

BACKENDS: tuple[BackendName, ...] = get_args(BackendName)
"""`cpu`: the engine itself, on threads, to the bits of one arm alone. `warp`: MuJoCo Warp, on a GPU, in single
precision."""

_HOMES: dict[str, str] = {"cpu": "plants:Plants", "warp": "warp:WarpPlants"}
"""Classes with the interface of `engine.plants.Plants`."""


def check_backend(name: str) -> None:
    """Refuse what is no backend, or is not installed.

    Raises:
        InputError: lists those that there are.
        MissingError: says how to get it.
    """
    if name not in BACKENDS:
        raise InputError("backend", repr(name), ", ".join(BACKENDS))
    _kind(name).check_installed()


def together(plants: Sequence[Plant], threads: int = 0, backend: str = "cpu") -> Plants:
    """Return arms of one layout, stepped together from where they are, see `Plants.of`.

    Raises:
        InputError: what the backend cannot step.
    """
    return _kind(backend).of(plants, threads)


def alike(plant: Plant, backend: str = "cpu") -> Any:
    """Return what arms that are stepped together have in common beside their layout, to be compared and hashed.

    Raises:
        InputError: what the backend cannot step.
    """
    return _kind(backend).alike(plant)


def at_once(backend: str = "cpu") -> int:
    """Return how many motions are under way together at most."""
    return _kind(backend).at_once


def _kind(backend: str) -> type[Plants]:
    module, kind = _HOMES[backend].split(":")
    found: type[Plants] = getattr(import_module(f"contarm_sim.engine.{module}"), kind)
    return found

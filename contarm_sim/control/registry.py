"""The controllers by name, for the command line; importing this loads none of them."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from contarm_sim.errors import InputError

if TYPE_CHECKING:
    from contarm_sim.control.base import Controller

_HOMES = {
    "paper": "paper:Paper",
    "chain": "chain:Chain",
    "feedforward": "feedforward:Feedforward",
    "servo": "servo:Servo",
    "pressure": "pressure:Pressure",
    "tip": "tip:Tip",
}

NAMES = tuple(_HOMES)
"""Each adds one thing to the one before, but `pressure`, which is `servo` through pneumatic muscles."""


def controller(given: str | Controller) -> Controller:
    """Return the controller of a name, or the one given.

    Raises:
        InputError: an unknown name, or no controller.
    """
    if isinstance(given, str) and given in _HOMES:
        module, kind = _HOMES[given].split(":")
        made: Controller = getattr(import_module(f"contarm_sim.control.{module}"), kind)()
        return made
    if hasattr(given, "resting") and not isinstance(given, type):
        return given  # type: ignore[return-value]
    raise InputError("controller", repr(given), ", ".join(NAMES) + ", or an object of a subclass of Controller")

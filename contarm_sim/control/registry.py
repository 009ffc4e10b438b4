"""The controllers by name, for the command line; importing this loads none of them."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Literal, get_args

from contarm_sim.errors import InputError

if TYPE_CHECKING:
    from contarm_sim.control.base import Controller

ControllerName = Literal["paper", "chain", "feedforward", "servo", "pressure", "tip"]  # what type checkers know

NAMES: tuple[ControllerName, ...] = get_args(ControllerName)
"""Each adds one thing to the one before, but `pressure`, which is `servo` through pneumatic muscles."""

_HOMES: dict[ControllerName, str] = {
    "paper": "paper:Paper",
    "chain": "chain:Chain",
    "feedforward": "feedforward:Feedforward",
    "servo": "servo:Servo",
    "pressure": "pressure:Pressure",
    "tip": "tip:Tip",
}


def controller(given: str | Controller) -> Controller:
    """Return the controller of a name, or the one given.

    Raises:
        InputError: an unknown name, or no controller.
    """
    if isinstance(given, str) and given in _HOMES:
        module, kind = _HOMES[given].split(":")
        made: Controller = getattr(import_module(f"contarm_sim.control.{module}"), kind)()
        return made
    from contarm_sim.control.base import Controller

    if isinstance(given, Controller):
        return given
    raise InputError("controller", repr(given), ", ".join(NAMES) + ", or an object of your own subclass of Controller")

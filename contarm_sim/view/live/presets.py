"""The arms that the page offers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from contarm_sim.model import presets
from contarm_sim.model.arm import Arm

GIVEN = "as started"

ARMS: dict[str, Callable[[], Arm]] = {
    "paper's arm": presets.paper,
    "paper's, hanging": lambda: replace(presets.paper(), world=presets.HANGING),
    "paper's, hanging, 100 g": lambda: replace(presets.paper(), world=replace(presets.HANGING, payload=0.1)),
    "two sections": presets.two,
    "three sections": presets.three,
    "three, nine tendons": presets.tendon,
}
"""Arms by what the page calls them."""


def offered(given: Arm) -> dict[str, Arm]:
    """Return arms by name; the one that the page was started with is the first, if it is not among the others."""
    arms = {name: make() for name, make in ARMS.items()}
    return arms if given in arms.values() else {GIVEN: given, **arms}


def name_of(arm: Arm, arms: dict[str, Arm]) -> str:
    """Return the name of an arm among others; the first where it is none of them."""
    return next((name for name, other in arms.items() if other == arm), next(iter(arms)))

"""The paper's figures and ours, each computed when it is drawn: `FIGURES` names them."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from contarm_sim.model.arm import Arm
from contarm_sim.view.report.style import Files

Draw = Callable[[Files, Arm], None]


def _drawn_by(module: str, name: str) -> Draw:
    """Return a function of this package, imported when it draws."""

    def draw(path: Files, arm: Arm) -> None:
        getattr(import_module(f"{__name__}.{module}"), name)(path, arm)

    return draw


FIGURES: dict[str, tuple[str, Draw]] = {
    "fan": (
        "forward kinematics: arcs by bend and plane, simulated chains on top",
        _drawn_by("paper", "fan"),
    ),
    "possibility": (
        "lengths of muscles 2 and 3 that are possible, and the pressures that hold them",
        _drawn_by("paper", "possibility"),
    ),
    "spiral": ("the paper's spiral on its shell, and the nearest one on the dome", _drawn_by("paper", "spiral")),
    "angles": ("bend and plane angle along the spiral, over time", _drawn_by("paper", "angles")),
    "lengths": ("lengths of muscles 2 and 3 along the spiral, over time", _drawn_by("paper", "lengths")),
    "lengths-on-map": ("the same lengths over the possibility map", _drawn_by("paper", "lengths_on_map")),
    "error-map": ("tip error over the dome, five scenarios", _drawn_by("studies", "error_map")),
    "budget": ("tip error along the spiral, stacked by where it comes from", _drawn_by("studies", "budget")),
    "convergence": ("tip error against the number of links", _drawn_by("studies", "convergence")),
    "controllers": ("tip error of every controller, free and loaded", _drawn_by("studies", "controllers")),
    "stiffness": ("tip stiffness against pressure at 60 degrees", _drawn_by("studies", "stiffness")),
    "sag": ("gravity's effect against m g L^2/EI", _drawn_by("studies", "sag")),
}
"""Name, meaning and function of every figure."""

"""The paper's figures and ours, each computed when it is drawn: `FIGURES` names them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from contarm_sim.arm import Arm
from contarm_sim.figures import paper, studies

Draw = Callable[[Path, Arm], None]

FIGURES: dict[str, tuple[str, Draw]] = {
    "fan": ("forward kinematics: arcs by bend and plane, simulated chains on top", paper.fan),
    "possibility": (
        "lengths of muscles 2 and 3 that are possible, and the pressures that hold them",
        paper.possibility,
    ),
    "spiral": ("the paper's spiral on its shell, and the nearest one on the dome", paper.spiral),
    "angles": ("bend and plane angle along the spiral, over time", paper.angles),
    "lengths": ("lengths of muscles 2 and 3 along the spiral, over time", paper.lengths),
    "lengths-on-map": ("the same lengths over the possibility map", paper.lengths_on_map),
    "error-map": ("tip error over the dome, five scenarios", studies.error_map),
    "budget": ("tip error along the spiral, stacked by where it comes from", studies.budget),
    "convergence": ("tip error against the number of links", studies.convergence),
    "controllers": ("tip error of every controller, free and loaded", studies.controllers),
    "stiffness": ("tip stiffness against pressure at 60 degrees", studies.stiffness),
    "sag": ("gravity's effect against m g L^2/EI", studies.sag),
}
"""Name, meaning and function of every figure."""

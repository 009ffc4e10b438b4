"""The paper's spiral on its shell, which the tip cannot reach, and the nearest one on the dome."""

from __future__ import annotations

from contarm_sim.kinematics import arc
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import TARGET
from contarm_sim.view.figures.common import BROAD, THIN, followed
from contarm_sim.view.space import add_space
from contarm_sim.view.stance import stance
from contarm_sim.view.style import Sheet
from contarm_sim.view.trim import trim


def spiral(sheet: Sheet, arm: Arm) -> None:
    """Draw the paper's spiral on its spherical shell, the nearest tips that arcs reach, and the simulated ones."""
    samples = followed(arm, None, "nearest")
    sheet.heading(f"The paper's spiral and the nearest one that the tip can reach ({stance(arm)})")
    ax = add_space(sheet, arm)
    ax.reachable()
    ax.trace(samples.target, color=TARGET, linestyle=(0, (4, 2)), label="paper's, on its shell")
    ax.trace(samples.stations[:, -1], **BROAD | {"label": "simulated tip"})
    ax.trace(arc.position(samples.bend, arm.length), **THIN | {"label": "nearest, analytic tip"})
    ax.settle()
    trim(sheet, 105)

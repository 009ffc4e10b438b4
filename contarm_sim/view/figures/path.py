"""The path of the tip in space, asked for and simulated."""

from __future__ import annotations

from contarm_sim.model.arm import Arm
from contarm_sim.results.compare import compare
from contarm_sim.view.figures.common import OwnPath, followed
from contarm_sim.view.report.run_figures import draw_path
from contarm_sim.view.style import Sheet


def path(sheet: Sheet, arm: Arm, own: OwnPath | None = None) -> None:
    """Draw what the tip is asked to follow, what it does, and the arm at the end."""
    samples = followed(arm, own)
    draw_path(sheet, samples, compare(samples))

"""The path of the tip in space, asked for and simulated."""

from __future__ import annotations

from contarm_sim.model.arm import Arm
from contarm_sim.results.compare import compare
from contarm_sim.view.figures.common import Way, followed
from contarm_sim.view.report.run_figures import draw_path
from contarm_sim.view.style import Sheet


def path(fig: Sheet, arm: Arm, way: Way | None = None) -> None:
    """Draw what the tip is asked to follow, what it does, and the arm at the end."""
    samples = followed(arm, way)
    draw_path(fig, samples, compare(samples))

"""Our own figures: where the two derivations differ, by pose, time, link count, controller and pressure."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.motion.lag import moved_by_motion
from contarm_sim.results.compare import Comparison, compare
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.studies import convergence as refinement
from contarm_sim.studies.at_rest import Failure, Outcome
from contarm_sim.studies.attempts import attempt
from contarm_sim.studies.controllers import compare_controllers
from contarm_sim.studies.scenarios import dome_grid, scenarios
from contarm_sim.studies.tip_stiffness import Stiffness
from contarm_sim.studies.tip_stiffness import stiffness as tip_stiffness
from contarm_sim.view.figures.common import DURATION, OwnPath, followed
from contarm_sim.view.once import once
from contarm_sim.view.report.budget import draw_parts
from contarm_sim.view.report.error_maps import draw_error_maps
from contarm_sim.view.report.errors_by_bend import draw_errors_by_bend
from contarm_sim.view.report.study_figures import draw_controllers, draw_convergence, draw_stiffness
from contarm_sim.view.style import Sheet

GRID = 6


def errors_by_bend(sheet: Sheet, arm: Arm) -> None:
    """Draw tip error at rest against bend angle, a line a scenario."""
    draw_errors_by_bend(sheet, arm, _at_rest(arm, GRID))


def error_map(sheet: Sheet, arm: Arm) -> None:
    """Draw tip error over the dome at rest, a polar map a scenario."""
    draw_error_maps(sheet, arm, _at_rest(arm, GRID))


@once
def _at_rest(arm: Arm, grid: int) -> list[Outcome | Failure]:
    return [attempt(scenario, dome_grid(grid)) for scenario in scenarios(arm)]


def budget(sheet: Sheet, arm: Arm, own: OwnPath | None = None) -> None:
    """Draw the tip error along a path, and its parts along it, stacked."""
    draw_parts(sheet, *_split(arm, own))


@once
def _split(arm: Arm, own: OwnPath | None) -> tuple[Trajectory, Comparison, tuple[Array, Array]]:
    samples = followed(arm, own)
    return samples, compare(samples), moved_by_motion(samples)


def convergence(sheet: Sheet, arm: Arm) -> None:
    """Draw the largest tip error over the dome against the number of links, with its slope."""
    draw_convergence(sheet, _refined(arm, GRID))


@once
def _refined(arm: Arm, grid: int) -> refinement.Convergence:
    return refinement.convergence(arm, dome_grid(grid))


def controllers(sheet: Sheet, arm: Arm) -> None:
    """Draw the tip error of every controller along the spiral, and the part that muscle lengths could correct."""
    draw_controllers(sheet, _compared(arm, DURATION))


_compared = once(compare_controllers)


def stiffness(sheet: Sheet, arm: Arm) -> None:
    """Draw tip stiffness against pressure at 60 degrees, closed form and simulated."""
    draw_stiffness(sheet, _stiffness(arm))


@once
def _stiffness(arm: Arm) -> Stiffness:
    return tip_stiffness(arm, arc.from_polar(np.pi / 3, 0.0))

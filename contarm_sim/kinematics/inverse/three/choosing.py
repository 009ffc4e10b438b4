"""One solution of three sections for each pose of the tip, or for each position and direction, by a choice of all."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import Choice, penalty
from contarm_sim.kinematics.inverse.general.out_of_reach import nearest
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.result import Inverse
from contarm_sim.kinematics.inverse.rotations import rotation_to
from contarm_sim.kinematics.inverse.three.newton import polished
from contarm_sim.kinematics.inverse.three.rolls import Rank, best_rolls
from contarm_sim.kinematics.inverse.three.search import one_arc
from contarm_sim.kinematics.inverse.three.solutions import all_solutions, without_tool


def solve_pose(goals: Goals, backbone: Backbone, choose: Choice, near: Array | None) -> Inverse:
    """Return one solution of each pose; where there is none, the nearest pose that damped least squares find.

    `solutions` is -1 where one arc reaches the pose and a continuum of bends with it.

    Args:
        goals: poses.
        backbone: three sections; the only connector is the tool at the tip.
        near: bends [rad], shape (n, 3, 2), for `nearest`.
    """
    rank, (ends, bare) = _rank(backbone, choose, near), without_tool(goals, backbone)
    found, count = all_solutions(ends, bare)
    ranks, (row, place) = np.full(found.shape[:2], np.inf), np.nonzero(np.isfinite(found[..., 0, 0]))
    ranks[row, place] = rank(found[row, place], row)
    bends = found[np.arange(len(found)), np.argmin(ranks, axis=1)]
    none = np.flatnonzero(count == 0)
    if none.size:
        left = ends.take(none)
        bends[none] = polished(left, nearest(left, bare), bare)
    assert ends.rotation is not None
    straight = np.linalg.norm(ends.position, axis=-1) > bare.length * (1 - 1e-12)
    continuum = one_arc(ends.position, ends.rotation, bare) & ~straight & (count > 0)
    # one that least squares found is one
    return goals.answered(bends, backbone, np.where(continuum, -1, np.maximum(count, 1)))


def solve_direction(goals: Goals, backbone: Backbone, choose: Choice, near: Array | None) -> Inverse:
    """Return one solution of each position and direction of the tip, of the continuum that its roll leaves.

    Arguments as of `solve_pose`; where none is found, the nearest.
    """
    assert goals.direction is not None
    ends, bare = without_tool(Goals(goals.position, None, rotation_to(goals.direction)), backbone)
    bends = best_rolls(Goals(ends.position, goals.direction), bare, _rank(backbone, choose, near),
                       near if choose == "nearest" else None)  # fmt: skip
    return goals.answered(bends, backbone, -1)


def _rank(backbone: Backbone, choose: Choice, near: Array | None) -> Rank:
    return lambda bends, rows: penalty(bends, backbone, choose, None if near is None else near[rows])

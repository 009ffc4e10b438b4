"""One solution of three sections for each pose of the tip, or for each position and direction, by a choice of all."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import Choice, penalty
from contarm_sim.kinematics.inverse.general.out_of_reach import nearest
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.result import Bool, Inverse
from contarm_sim.kinematics.inverse.rotations import rotation_to
from contarm_sim.kinematics.inverse.three.newton import polished
from contarm_sim.kinematics.inverse.three.rolls import Rank, best_rolls
from contarm_sim.kinematics.inverse.three.search import one_arc
from contarm_sim.kinematics.inverse.three.solutions import all_solutions, without_tool

_ROUNDED = 1e-15  # distance from the axis, free of units


def solve_pose(goals: Goals, backbone: Backbone, choose: Choice, near: Array | None) -> Inverse:
    """Return one solution of each pose; where there is none, the nearest pose that damped least squares find.

    `solutions` is -1 where one arc reaches the pose and a continuum of bends with it, or where any turn about the axis
    of the base makes another: one of them is returned, of these turns the nearest for `nearest`.

    Args:
        goals: poses.
        backbone: three sections; the only connector is the tool at the tip.
        near: bends [rad], shape (n, 3, 2), for `nearest`.
    """
    rank, (ends, bare) = _rank(backbone, choose, near), without_tool(goals, backbone)
    found, count = all_solutions(ends, bare)
    assert ends.rotation is not None
    about = _on_axis(ends, bare)
    if choose == "nearest" and near is not None and about.any():
        found[about] = _turned_to(found[about], near[about])
    ranks, (row, place) = np.full(found.shape[:2], np.inf), np.nonzero(np.isfinite(found[..., 0, 0]))
    ranks[row, place] = rank(found[row, place], row)
    bends = found[np.arange(len(found)), np.argmin(ranks, axis=1)]
    none = np.flatnonzero(count == 0)
    if none.size:
        left = ends.take(none)
        bends[none] = polished(left, nearest(left, bare), bare)
    straight = np.linalg.norm(ends.position, axis=-1) > bare.length * (1 - 1e-12)
    continuum = (one_arc(ends.position, ends.rotation, bare) | about) & ~straight & (count > 0)
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


def _on_axis(goals: Goals, backbone: Backbone) -> Bool:
    """Return which poses are the same after a turn about the axis of the base, shape (n,), bool."""
    assert goals.rotation is not None
    aside = np.abs(goals.position[:, :2]).max(axis=-1) / backbone.length
    return np.asarray((np.maximum(aside, np.abs(goals.rotation[:, :2, 2]).max(axis=-1)) < _ROUNDED)
                      & (goals.rotation[:, 2, 2] > 0))  # fmt: skip


def _turned_to(found: Array, near: Array) -> Array:
    """Return solutions, shape (n, K, 3, 2), turned about the axis of the base so that they are nearest to bends."""
    x, y = found[..., 0], found[..., 1]
    to_x, to_y = near[:, None, :, 0], near[:, None, :, 1]
    angle = np.arctan2((x * to_y - y * to_x).sum(axis=-1), (x * to_x + y * to_y).sum(axis=-1))
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _rank(backbone: Backbone, choose: Choice, near: Array | None) -> Rank:
    return lambda bends, rows: penalty(bends, backbone, choose, None if near is None else near[rows])

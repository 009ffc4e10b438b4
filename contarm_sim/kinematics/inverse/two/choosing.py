"""One pose of two sections for each tip position, by a choice, or by the direction that its tip is to have.

A position leaves one parameter free; the choice goes along the curves that this makes. Two sections have four freedoms,
position and direction are five conditions: the pose whose tip comes nearest to the direction is taken. What cannot be
reached gets the nearest pose.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import Choice
from contarm_sim.kinematics.inverse.goals import Goals, judged
from contarm_sim.kinematics.inverse.limits import angles_of
from contarm_sim.kinematics.inverse.result import Index, Inverse
from contarm_sim.kinematics.inverse.tips import tip_axes
from contarm_sim.kinematics.inverse.two import curve
from contarm_sim.kinematics.inverse.two.boundary import nearest_bends
from contarm_sim.kinematics.inverse.two.equations import Targets, as_targets
from contarm_sim.kinematics.inverse.two.newton import polish, slide
from contarm_sim.kinematics.inverse.two.pair import Pair, as_pair
from contarm_sim.kinematics.inverse.two.pieces import Pieces, find

_BLOCK = 512  # targets at once: their samples stay in the processor's cache
_DOUBTFUL = 1e-12  # miss, in units of length, from which the boundary is asked too
_SAME = 1e-9  # bend angles [rad] this close are one
_STRAIGHT = 1e-7  # bend angle [rad] of a pose that rounding does not tell from the straight one

Residual = Callable[[Array, Index], Array]
"""What is to be small: of bends (n, ..., 2, 2) and the targets that they are of (n,), shape (n, ..., r)."""


def solve_two(goals: Goals, backbone: Backbone, choose: Choice, near: Array | None) -> Inverse:
    """Return one pose for each goal, a position or a position and direction.

    `solutions` is -1 where they are a continuum (on the axis, a circle: one of them is returned), 1 or 2 (a pose and
    its mirror image) on the boundary, 0 where none reaches the goal.

    Args:
        goals: without rotations.
        choose: where no direction is asked for.
        near: bends [rad], shape (n, 2, 2), for `nearest`.
    """
    pair, points, off = as_pair(backbone), goals.position / backbone.length, _residual(goals, choose, near)
    bends, miss, solutions = np.empty((len(points), 2, 2)), np.empty(len(points)), np.zeros(len(points), dtype=np.intp)
    for start in range(0, len(points), _BLOCK):
        at = slice(start, start + _BLOCK)
        own = None if off is None else lambda b, rows, start=start: off(b, rows + start)
        bends[at], miss[at], solutions[at] = _block(points[at], pair, choose, own)
    if goals.direction is not None:
        return goals.answered(bends, backbone, 1)
    return judged(bends, miss * backbone.length, np.zeros(len(points)), backbone, solutions)


def _residual(goals: Goals, choose: Choice, near: Array | None) -> Residual | None:
    """Return what is to be small, or None for a choice on bend angles alone."""
    if goals.direction is not None:
        direction = goals.direction
        return lambda bends, rows: tip_axes(bends) - direction[rows].reshape(-1, *[1] * (bends.ndim - 3), 3)
    if choose != "nearest" or near is None:
        return None

    def off(bends: Array, rows: Index) -> Array:
        own = near[rows].reshape(-1, *[1] * (bends.ndim - 3), 2, 2)
        return np.asarray((bends - own).reshape(*bends.shape[:-2], 4))

    return off


def _block(points: Array, pair: Pair, choose: Choice, off: Residual | None) -> tuple[Array, Array, Index]:
    """Return bends, misses in units of length, and numbers of solutions where they reach their targets."""
    bends, miss = np.zeros((len(points), 2, 2)), np.full(len(points), np.inf)
    solutions = np.ones(len(points), dtype=np.intp)
    targets = as_targets(points)
    pieces = find(pair, targets)
    if pieces.owner.size:
        if off is None:
            place = curve.least_bends(pair, targets, pieces, choose)
        else:
            place = curve.least(pair, targets, pieces, lambda b, rows: np.square(off(b, rows)).sum(axis=-1))
        some = place.owner
        found = curve.bends_at(pair, targets.at(some), place.beta1, place.cosine, place.branch)
        found, left = polish(pair, points[some], found)
        if off is not None:
            found, left = slide(pair, points[some], found, left, lambda b, rows: off(b, some[rows]))
        bends[some], miss[some], solutions[some] = found, left, _counted(targets, pieces, some, found)
    rest = np.flatnonzero(miss > _DOUBTFUL)
    if rest.size:
        found, left = polish(pair, points[rest], nearest_bends(pair, points[rest]))
        better = left < miss[rest]
        bends[rest[better]], miss[rest[better]], solutions[rest[better]] = found[better], left[better], 1
    return bends, miss, solutions


def _counted(targets: Targets, pieces: Pieces, owner: Index, bends: Array) -> Index:
    """Return how many solutions there are: -1, or 1 or 2 where the pieces are single places."""
    wide = np.zeros(len(targets.z))
    np.maximum.at(wide, pieces.owner, pieces.high - pieces.low)
    one, two = bends[:, 0], bends[:, 1]
    angle = angles_of(bends)
    across = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    planar = across <= _SAME * np.maximum(angle[:, 0] * angle[:, 1], _SAME)
    single = (angle.max(axis=-1) < _STRAIGHT) | ((wide[owner] < _SAME) & (targets.rho[owner] >= curve.ON_AXIS))
    return np.where(single, np.where(planar, 1, 2), -1)

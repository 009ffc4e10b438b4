"""Inverse kinematics of two sections: a tip position in closed form, all its solutions, and choices among them.

A position leaves one parameter free, `family` returns all of it. `solve_position` chooses from it for many targets at
once, `solve_direction` by the direction of the tip; what cannot be reached gets the nearest pose, as from `nearest`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.kinematics.backbone import Backbone, as_bends
from contarm_sim.kinematics.inverse import two_boundary, two_curve, two_pieces, two_polish, two_tip
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH, TOLERANCE, Inverse
from contarm_sim.kinematics.inverse.scalars import Index
from contarm_sim.kinematics.inverse.two_equations import Targets, as_targets
from contarm_sim.kinematics.inverse.two_family import Family, family
from contarm_sim.kinematics.inverse.two_pair import Pair, as_pair
from contarm_sim.kinematics.inverse.two_pieces import Pieces

CHOICES = ("least-bend", "least-largest", "farthest", "nearest")
"""Choices among the poses that reach a position."""

_BLOCK = 512  # targets at once: their samples stay in the processor's cache
_DOUBTFUL = 1e-12  # miss, in units of length, from which the boundary is asked too
_SAME = 1e-9  # bend angles [rad] this close are one
_STRAIGHT = 1e-7  # bend angle [rad] of a pose that rounding does not tell from the straight one

__all__ = ["CHOICES", "Family", "family", "nearest", "solve_direction", "solve_position"]


def solve_position(target: Any, backbone: Backbone, choose: str = "least-bend", near: Any = None) -> Inverse:
    """Return one pose for each tip position.

    Args:
        target: tip positions in the base frame [m], shape (..., 3).
        backbone: of two sections.
        choose: "least-bend", the least sum of the bend angles; "least-largest", the least larger one; "farthest", the
            largest least distance from the limits; "nearest", the least distance to `near` in bends.
        near: bends [rad], shape (2, 2) or (..., 2, 2), for "nearest".

    Returns:
        Poses within the limits. `solutions` is -1 where they are a continuum (on the axis, a circle: one of them is
        returned), 1 or 2 (a pose and its mirror image) on the boundary, 0 where none reaches the target; `bends` are
        then those of the nearest reachable position.

    Raises:
        InputError: a target that is not finite, a backbone of other than two sections, a choice that is none.
    """
    points, pair, shape = _given(target, backbone)
    if choose not in CHOICES:
        raise InputError("choose", choose, ", ".join(CHOICES))
    if choose != "nearest":
        return _solved(points, pair, backbone, shape, choose, None)
    if near is None:
        raise InputError("near", None, 'bends of both sections [rad], for choose="nearest"')
    wanted = as_bends(near, backbone)
    try:
        wanted = np.broadcast_to(wanted, (*shape, 2, 2)).reshape(-1, 2, 2)
    except ValueError:
        raise InputError("near", f"of shape {np.shape(near)}", f"shape (2, 2) or {(*shape, 2, 2)}") from None

    def off(bends: Array, rows: Index) -> Array:
        own = wanted[rows].reshape(-1, *[1] * (bends.ndim - 3), 2, 2)
        return np.asarray((bends - own).reshape(*bends.shape[:-2], 4))

    return _solved(points, pair, backbone, shape, None, off)


def solve_direction(target: Any, direction: Any, backbone: Backbone) -> Inverse:
    """Return the pose that reaches a position with the tip's axis nearest to a direction.

    Two sections have four freedoms, position and direction are five conditions: `angle_miss` says what is left.

    Args:
        target: tip positions in the base frame [m], shape (..., 3).
        direction: directions of the tip's z axis in the base frame, of any length but 0, shape (3,) or (..., 3).
        backbone: of two sections.

    Raises:
        InputError: as `solve_position`; a direction of length 0.
    """
    points, pair, shape = _given(target, backbone)
    wanted = as_vectors(direction, 3, "direction")
    largest = np.abs(wanted).max(axis=-1, keepdims=True)
    if not np.all(largest > 0):
        raise InputError("direction", [0.0, 0.0, 0.0], "a vector of length above 0")
    wanted = wanted / largest  # squares of very large or small ones would overflow
    wanted /= np.linalg.norm(wanted, axis=-1, keepdims=True)
    try:
        wanted = np.broadcast_to(wanted, (*shape, 3)).reshape(-1, 3)
    except ValueError:
        raise InputError("direction", f"of shape {np.shape(direction)}", f"shape (3,) or {(*shape, 3)}") from None

    def off(bends: Array, rows: Index) -> Array:
        return two_tip.tip_axis(bends) - wanted[rows].reshape(-1, *[1] * (bends.ndim - 3), 3)

    found = _solved(points, pair, backbone, shape, None, off)
    left = np.linalg.norm(two_tip.tip_axis(found.bends) - wanted.reshape(*shape, 3), axis=-1)
    angle = 2 * np.arcsin(np.minimum(0.5 * left, 1.0))
    reachable = found.reachable & (angle * ANGLE_LENGTH <= TOLERANCE)
    return Inverse(found.bends, found.miss, angle, reachable, np.where(reachable, 1, 0))


def nearest(target: Any, backbone: Backbone) -> Inverse:
    """Return the pose of the reachable position nearest to each target; of those that reach it, of least total bend.

    Arguments, shapes and errors as of `solve_position`.
    """
    return solve_position(target, backbone)


def _given(target: Any, backbone: Backbone) -> tuple[Array, Pair, tuple[int, ...]]:
    """Return targets in units of the backbone's length, shape (n, 3), the sections, and the leading axes."""
    pair = as_pair(backbone)
    points = as_vectors(target, 3, "target")
    return points.reshape(-1, 3) / backbone.length, pair, points.shape[:-1]


Residual = Callable[[Array, Index], Array]
"""What is to be small: of bends (n, ..., 2, 2) and the targets that they are of (n,), shape (n, ..., r)."""


def _solved(
    points: Array, pair: Pair, backbone: Backbone, shape: tuple[int, ...], choose: str | None, off: Residual | None
) -> Inverse:
    """Return answers by a choice on bend angles, or by the least residual."""
    bends, miss = np.empty((len(points), 2, 2)), np.empty(len(points))
    solutions = np.zeros(len(points), dtype=np.intp)
    for start in range(0, len(points), _BLOCK):
        at = slice(start, start + _BLOCK)
        own = None if off is None else lambda b, rows, start=start: off(b, rows + start)
        bends[at], miss[at], solutions[at] = _block(points[at], pair, choose, own)
    reachable = miss <= TOLERANCE
    solutions[~reachable] = 0
    return Inverse(
        bends.reshape(*shape, 2, 2),
        miss.reshape(shape) * backbone.length,
        np.zeros(shape),
        reachable.reshape(shape),
        solutions.reshape(shape),
    )


def _block(points: Array, pair: Pair, choose: str | None, off: Residual | None) -> tuple[Array, Array, Index]:
    """Return bends, misses in units of length, and numbers of solutions."""
    bends, miss = np.zeros((len(points), 2, 2)), np.full(len(points), np.inf)
    solutions = np.ones(len(points), dtype=np.intp)
    targets = as_targets(points)
    pieces = two_pieces.find(pair, targets)
    if pieces.owner.size:
        if off is None:
            assert choose is not None
            place = two_curve.least_bends(pair, targets, pieces, choose)
        else:
            place = two_curve.least(pair, targets, pieces, lambda b, rows: np.square(off(b, rows)).sum(axis=-1))
        some = place.owner
        found = two_curve.bends_at(pair, targets.at(some), place.beta1, place.cosine, place.branch)
        found, left = two_polish.polish(pair, points[some], found)
        if off is not None:
            found, left = two_polish.slide(pair, points[some], found, left, lambda b, rows: off(b, some[rows]))
        bends[some], miss[some], solutions[some] = found, left, _counted(targets, pieces, some, found)
    rest = np.flatnonzero(miss > _DOUBTFUL)
    if rest.size:
        found, left = two_polish.polish(pair, points[rest], two_boundary.nearest_bends(pair, points[rest]))
        better = left < miss[rest]
        bends[rest[better]], miss[rest[better]], solutions[rest[better]] = found[better], left[better], 1
    return bends, miss, solutions


def _counted(targets: Targets, pieces: Pieces, owner: Index, bends: Array) -> Index:
    """Return how many solutions there are: -1, or 1 or 2 where the pieces are single places."""
    wide = np.zeros(len(targets.z))
    np.maximum.at(wide, pieces.owner, pieces.high - pieces.low)
    one, two = bends[:, 0], bends[:, 1]
    angle = np.hypot(bends[..., 0], bends[..., 1])
    across = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    planar = across <= _SAME * np.maximum(angle[:, 0] * angle[:, 1], _SAME)
    single = (angle.max(axis=-1) < _STRAIGHT) | ((wide[owner] < _SAME) & (targets.rho[owner] >= two_curve.ON_AXIS))
    return np.where(single, np.where(planar, 1, 2), -1)

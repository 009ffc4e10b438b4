"""Position and direction of three sections: the best along the curves of solutions that the free roll leaves.

Poses of sampled rolls are solved; from the best few, steps along the curve go down until they are short. A step follows
the null vector of position and direction by the bends, so it also passes where the roll turns back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.pose_nearest import nearest, off_and_jacobian
from contarm_sim.kinematics.inverse.pose_newton import SOLVED
from contarm_sim.kinematics.inverse.pose_search import Bool, Index
from contarm_sim.kinematics.inverse.pose_solutions import solutions

Rank = Callable[[Array, Index], Array]
"""What is least at the best: of bends (m, 3, 2) of the targets (m,) given, as (m,)."""

_ROLLS, _NODES, _BEST = 24, 48, 3
_STEPS, _FIRST, _PROBE = 60, 0.1, 1e-6  # the steps along the curve: how many, the first one and a probe [rad]
_SHORT, _CORRECTIONS = 1e-8, 4
_WIDEST = 3.14  # bends to which solutions are followed on their way back to the limits [rad]


def rotation_to(direction: Array) -> Array:
    """Return rotations whose last columns are unit vectors, shape (n, 3, 3): the turns of least angle from e3."""
    x, y, z = direction.T
    out = np.empty((len(direction), 3, 3))
    down = z < -1 + 1e-12  # any half-turn about a level axis will do
    share = 1 / np.where(down, 1.0, 1 + z)
    out[:, 0, 0], out[:, 1, 1], out[:, 0, 1] = 1 - share * x * x, 1 - share * y * y, -share * x * y
    out[:, 1, 0] = out[:, 0, 1]
    out[:, 2, 0], out[:, 2, 1] = -x, -y
    out[down] = np.diag([1.0, -1.0, -1.0])
    out[:, :, 2] = direction
    return out


def best_rolls(position: Array, rotation: Array, backbone: Backbone, rank: Rank, near: Array | None = None) -> Array:
    """Return the best bends over all rolls about the last columns of rotations, shape (n, 3, 2).

    Where no roll leads there, the bends of the least miss known.

    Args:
        position: of the end of section 3 [m], shape (n, 3).
        rotation: one for each direction, shape (n, 3, 3).
        backbone: three sections, no connectors.
        rank: says which is best.
        near: bends that a further start lies next to, shape (n, 3, 2).
    """
    rows = np.arange(len(position))
    best, value = _sampled(position, rotation, backbone, rank, _ROLLS)
    if near is not None:
        best[:, -1], inside = _onto(position, rotation, near, backbone)
        value[:, -1] = np.inf
        value[inside, -1] = rank(best[inside, -1], rows[inside])
    none = np.flatnonzero(np.isinf(value).all(axis=1))
    if none.size:
        best[none, 0], inside = _found_otherwise(position[none], rotation[none], backbone)
        reached = none[inside]
        value[reached, 0] = rank(best[reached, 0], reached)
    row, place = np.nonzero(np.isfinite(value))
    best[row, place], value[row, place] = _lowered(
        position[row], rotation[row], best[row, place], backbone, lambda bends, which: rank(bends, row[which])
    )
    return np.asarray(best[rows, np.argmin(value, axis=1)])


def _sampled(position: Array, rotation: Array, backbone: Backbone, rank: Rank, rolls: int) -> tuple[Array, Array]:
    """Return the best few solutions of sampled rolls, shape (n, few, 3, 2), and their ranks; infinite where NaN."""
    count = len(position)
    best, value = np.full((count, _BEST, 3, 2), np.nan), np.full((count, _BEST), np.inf)
    for roll in np.arange(rolls) * (2 * np.pi / rolls):
        found, _ = solutions(position, _rolled(rotation, roll), backbone, _NODES, 0)
        row, place = np.nonzero(np.isfinite(found[..., 0, 0]))
        ranks = np.full(found.shape[:2], np.inf)
        ranks[row, place] = rank(found[row, place], row)
        best, value = np.concatenate([best, found], axis=1), np.concatenate([value, ranks], axis=1)
        first = np.argsort(value, axis=1, kind="stable")[:, :_BEST]
        best = np.take_along_axis(best, first[..., None, None], axis=1)
        value = np.take_along_axis(value, first, axis=1)
    return best, value


def _found_otherwise(position: Array, rotation: Array, backbone: Backbone) -> tuple[Array, Bool]:
    """Return bends where no sampled roll is within the limits, shape (n, 3, 2), and which are solutions.

    The best of solutions beyond the limits goes along its curve until it is within them, or does not come closer.
    """
    limits = np.asarray(backbone.limits)

    def beyond(bends: Array, rows: Index) -> Array:
        return np.asarray((np.hypot(bends[..., 0], bends[..., 1]) - limits).max(axis=-1))

    wide = replace(backbone, limits=tuple(np.maximum(limits, _WIDEST)))
    best, value = _sampled(position, rotation, wide, beyond, 3 * _ROLLS)
    out = np.full((len(position), 3, 2), np.nan)
    row, place = np.nonzero(np.isfinite(value))
    best[row, place], value[row, place] = _lowered(position[row], rotation[row], best[row, place], wide, beyond)
    first = np.argmin(value, axis=1)
    found = value[np.arange(len(out)), first] <= 0
    out[found] = best[found, first[found]]
    none = np.flatnonzero(~found)
    if none.size:
        out[none] = nearest(position[none], rotation[none], backbone, roll=False)
        there, found[none] = _onto(position[none], rotation[none], out[none], backbone)
        out[none[found[none]]] = there[found[none]]
    return out, found


def _lowered(position: Array, rotation: Array, bends: Array, backbone: Backbone, rank: Rank) -> tuple[Array, Array]:
    """Return the bends at a least rank along their curves, and their ranks."""
    bends, going = bends.copy(), np.arange(len(bends))
    value, step = rank(bends, going), np.full(len(bends), _FIRST)
    for _ in range(_STEPS):
        at, probe = bends[going], _along(position[going], rotation[going], bends[going], backbone)
        ahead = rank(at + _PROBE * probe, going) <= rank(at - _PROBE * probe, going)
        probe *= np.where(ahead, 1.0, -1.0)[:, None, None]
        tried = at + step[going, None, None] * probe
        tried, inside = _onto(position[going], rotation[going], tried, backbone)
        new = rank(tried, going)
        better = (new < value[going]) & inside
        bends[going[better]], value[going[better]] = tried[better], new[better]
        step[going] *= np.where(better, 1.5, 0.4)
        going = going[step[going] > _SHORT]
        if not going.size:
            break
    return bends, value


def _along(position: Array, rotation: Array, bends: Array, backbone: Backbone) -> Array:
    """Return unit vectors along curves of solutions, shape (n, 3, 2)."""
    _, J = off_and_jacobian(position, rotation, bends, backbone, False)
    return np.asarray(np.linalg.svd(J)[2][:, -1].reshape(-1, 3, 2))


def _onto(position: Array, rotation: Array, bends: Array, backbone: Backbone) -> tuple[Array, Bool]:
    """Return the solutions next to bends, and which are solutions within the limits."""
    for left in range(_CORRECTIONS, -1, -1):
        off, J = off_and_jacobian(position, rotation, bends, backbone, False)
        if not left:
            break
        u, s, v = np.linalg.svd(J)
        s[:, -1] = np.inf
        step = np.einsum("nji,nj->ni", v, np.einsum("nij,ni->nj", u, off) / np.maximum(s, 1e-12))
        bends = bends - step.reshape(-1, 3, 2)
    solved = np.sqrt(np.sum(off * off, axis=-1)) <= SOLVED
    return bends, solved & (np.hypot(bends[..., 0], bends[..., 1]) <= backbone.limits).all(axis=-1)


def _rolled(rotation: Array, roll: float) -> Array:
    c, s = np.cos(roll), np.sin(roll)
    x, y = rotation[:, :, 0], rotation[:, :, 1]
    return np.stack([c * x + s * y, c * y - s * x, rotation[:, :, 2]], axis=-1)

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
from contarm_sim.kinematics.inverse.general.free import along
from contarm_sim.kinematics.inverse.general.out_of_reach import nearest
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import excess
from contarm_sim.kinematics.inverse.result import Bool, Index
from contarm_sim.kinematics.inverse.rotations import rotation_to
from contarm_sim.kinematics.inverse.three.newton import SOLVED
from contarm_sim.kinematics.inverse.three.solutions import all_solutions

Rank = Callable[[Array, Index], Array]
"""What is least at the best: of bends (m, 3, 2) of the targets (m,) given, as (m,)."""

_ROLLS, _NODES, _BEST = 24, 48, 3
_STEPS, _FIRST, _PROBE = 60, 0.1, 1e-6  # the steps along the curve: how many, the first one and a probe [rad]
_SHORT, _CORRECTIONS = 1e-8, 4
_WIDEST = 3.14  # bends to which solutions are followed on their way back to the limits [rad]


def best_rolls(goals: Goals, backbone: Backbone, rank: Rank, near: Array | None = None) -> Array:
    """Return the best bends over all rolls about directions, shape (n, 3, 2).

    Where no roll leads there, the bends of the least miss known.

    Args:
        goals: positions of the end of section 3, and directions.
        backbone: three sections, no connectors.
        rank: says which is best.
        near: bends that a further start lies next to, shape (n, 3, 2).
    """
    rows = np.arange(len(goals))
    best, value = _sampled(goals, backbone, rank, _ROLLS)
    if near is not None:
        best[:, -1], inside = _onto(goals, near, backbone)
        value[:, -1] = np.inf
        value[inside, -1] = rank(best[inside, -1], rows[inside])
    none = np.flatnonzero(np.isinf(value).all(axis=1))
    if none.size:
        best[none, 0], inside = _found_otherwise(goals.take(none), backbone)
        reached = none[inside]
        value[reached, 0] = rank(best[reached, 0], reached)
    best, value = _all_lowered(goals, best, value, backbone, rank)
    return np.asarray(best[rows, np.argmin(value, axis=1)])


def _sampled(goals: Goals, backbone: Backbone, rank: Rank, rolls: int) -> tuple[Array, Array]:
    """Return the best few solutions of sampled rolls, shape (n, few, 3, 2), and their ranks; infinite where NaN."""
    count = len(goals)
    assert goals.direction is not None
    rotation = rotation_to(goals.direction)
    best, value = np.full((count, _BEST, 3, 2), np.nan), np.full((count, _BEST), np.inf)
    for roll in np.arange(rolls) * (2 * np.pi / rolls):
        found, _ = all_solutions(Goals(goals.position, None, _rolled(rotation, roll)), backbone, _NODES, 0)
        row, place = np.nonzero(np.isfinite(found[..., 0, 0]))
        ranks = np.full(found.shape[:2], np.inf)
        ranks[row, place] = rank(found[row, place], row)
        best, value = np.concatenate([best, found], axis=1), np.concatenate([value, ranks], axis=1)
        first = np.argsort(value, axis=1, kind="stable")[:, :_BEST]
        best = np.take_along_axis(best, first[..., None, None], axis=1)
        value = np.take_along_axis(value, first, axis=1)
    return best, value


def _found_otherwise(goals: Goals, backbone: Backbone) -> tuple[Array, Bool]:
    """Return bends where no sampled roll is within the limits, shape (n, 3, 2), and which are solutions.

    The best of solutions beyond the limits goes along its curve until it is within them, or does not come closer.
    """

    def beyond(bends: Array, rows: Index) -> Array:
        return excess(bends, backbone)

    wide = replace(backbone, limits=tuple(np.maximum(backbone.limits, _WIDEST)))
    best, value = _all_lowered(goals, *_sampled(goals, wide, beyond, 3 * _ROLLS), wide, beyond)
    out = np.full((len(goals), 3, 2), np.nan)
    first = np.argmin(value, axis=1)
    found = value[np.arange(len(out)), first] <= 0
    out[found] = best[found, first[found]]
    none = np.flatnonzero(~found)
    if none.size:
        out[none] = nearest(goals.take(none), backbone)
        there, found[none] = _onto(goals.take(none), out[none], backbone)
        out[none[found[none]]] = there[found[none]]
    return out, found


def _all_lowered(goals: Goals, best: Array, value: Array, backbone: Backbone, rank: Rank) -> tuple[Array, Array]:
    """Return what is known, the bends at a least rank along their curves, and their ranks."""
    row, place = np.nonzero(np.isfinite(value))
    best[row, place], value[row, place] = _lowered(
        goals.take(row), best[row, place], backbone, lambda bends, which: rank(bends, row[which])
    )
    return best, value


def _lowered(goals: Goals, bends: Array, backbone: Backbone, rank: Rank) -> tuple[Array, Array]:
    bends, going = bends.copy(), np.arange(len(bends))
    value, step = rank(bends, going), np.full(len(bends), _FIRST)
    for _ in range(_STEPS):
        if not going.size:
            break
        own, at = goals.take(going), bends[going]
        probe = along(own, backbone, at)
        ahead = rank(at + _PROBE * probe, going) <= rank(at - _PROBE * probe, going)
        probe *= np.where(ahead, 1.0, -1.0)[:, None, None]
        tried, inside = _onto(own, at + step[going, None, None] * probe, backbone)
        new = rank(tried, going)
        better = (new < value[going]) & inside
        bends[going[better]], value[going[better]] = tried[better], new[better]
        step[going] *= np.where(better, 1.5, 0.4)
        going = going[step[going] > _SHORT]
    return bends, value


def _onto(goals: Goals, bends: Array, backbone: Backbone) -> tuple[Array, Bool]:
    """Return the solutions next to bends, and which are solutions within the limits."""
    for left in range(_CORRECTIONS, -1, -1):
        off, J = goals.terms(bends, backbone)
        if not left:
            break
        u, s, v = np.linalg.svd(J)
        s[:, -1] = np.inf
        step = np.einsum("nji,nj->ni", v, np.einsum("nij,ni->nj", u, off) / np.maximum(s, 1e-12))
        bends = bends + step.reshape(-1, 3, 2)
    solved = np.sqrt(np.sum(off * off, axis=-1)) <= SOLVED
    return bends, solved & (excess(bends, backbone) <= 0)


def _rolled(rotation: Array, roll: float) -> Array:
    c, s = np.cos(roll), np.sin(roll)
    x, y = rotation[:, :, 0], rotation[:, :, 1]
    return np.stack([c * x + s * y, c * y - s * x, rotation[:, :, 2]], axis=-1)

"""One solution of each goal, of any number of sections: damped least squares from several starts, then a choice.

Where there are as many conditions as bends or more, solutions are isolated, and those among which the choice is made
are those that the starts led to, not surely all. `farthest` and `least-largest` are settled by a high power in place of
the largest.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import Choice, distinct, penalty
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.general.out_of_reach import approached
from contarm_sim.kinematics.inverse.general.settling import POWERS, settle
from contarm_sim.kinematics.inverse.general.starts import spread
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import clamped, excess
from contarm_sim.kinematics.inverse.result import Bool, Inverse

STARTS = 8
"""Starts of every target; the choice is among what they lead to."""

MORE = (8, 16, 32, 64, 128)
"""Further starts of a target that those before it left unsolved."""

ROUNDS = (6, 8)
"""Most steps along a surface of solutions, down to the choice: of all solutions, then of the best."""

_BLOCK = 4096  # targets at a time


def solve_general(
    goals: Goals, backbone: Backbone, choose: Choice = "least-bend", near: Array | None = None
) -> Inverse:
    """Return one answer for each goal; `near`, bends [rad] of shape (n, S, 2), are a start in any case."""
    best, solutions = np.zeros((len(goals), len(backbone), 2)), np.zeros(len(goals), dtype=np.intp)
    for first in range(0, len(goals), _BLOCK):
        block = slice(first, first + _BLOCK)
        own = None if near is None else near[block]
        best[block], solutions[block] = _solve(goals.take(block), backbone, choose, own)
    return goals.answered(best, backbone, solutions)


def _solve(goals: Goals, backbone: Backbone, choose: Choice, near: Array | None) -> tuple[Array, Array]:
    """Return bends, and how many solutions there are where they reach their goals."""
    count, size = len(goals), len(backbone)
    start = np.broadcast_to(spread(STARTS, backbone), (count, STARTS, size, 2))
    if near is not None:
        start = np.concatenate([start, near[:, None]], axis=1)
    bends, good = _from_starts(goals, backbone, start)
    best, found = _chosen(goals, backbone, bends, good, choose, near)
    first = STARTS
    for more in MORE:
        rows = np.flatnonzero(~found)
        if not len(rows):
            break
        these, own = goals.take(rows), None if near is None else near[rows]
        start = np.broadcast_to(spread(more, backbone, first), (len(rows), more, size, 2))
        again, good_again = _from_starts(these, backbone, start)
        first += more
        new, new_found = _chosen(these, backbone, again, good_again, choose, own)
        # What is not solved is kept by its miss alone.
        closer = new_found | (these.off(new, backbone) < these.off(best[rows], backbone))
        best[rows[closer]], found[rows] = new[closer], new_found
    _polish(goals, backbone, best)
    best[~found] = approached(goals.take(~found), backbone, best[~found])
    continuum = 2 * size > goals.conditions
    return best, np.full(count, -1) if continuum else np.maximum(distinct(bends, good).sum(axis=1), 1)


def _from_starts(goals: Goals, backbone: Backbone, start: Array) -> tuple[Array, Bool]:
    """Return what K starts lead to, shape (n, K, S, 2), and which of it is a solution, shape (n, K)."""
    count, each = start.shape[:2]
    owner = goals.take(np.repeat(np.arange(count), each))
    found = descend(owner, backbone, start.reshape(count * each, *start.shape[2:]))
    good = owner.solved(found, backbone)
    return clamped(found, backbone).reshape(start.shape), good.reshape(count, each)


def _chosen(
    goals: Goals, backbone: Backbone, bends: Array, good: Bool, choose: Choice, near: Array | None
) -> tuple[Array, Bool]:
    """Return the best solution of each goal after settling, or the least miss, and whether it is a solution."""
    row, column = np.nonzero(good)
    cost = np.full(good.shape, np.inf)
    if len(row):
        own = None if near is None else near[row]
        picked = bends[row, column]
        if 2 * len(backbone) > goals.conditions:
            picked = settle(goals.take(row), backbone, picked, choose, own, ROUNDS[0], POWERS[0])
        bends = bends.copy()
        bends[row, column] = picked
        cost[row, column] = penalty(picked, backbone, choose, own)
    unsolved = np.flatnonzero(~good.any(axis=1))
    for k in range(bends.shape[1]):
        cost[unsolved, k] = goals.take(unsolved).off(bends[unsolved, k], backbone)
    best, found = bends[np.arange(len(bends)), cost.argmin(axis=1)], np.asarray(good.any(axis=1))
    if 2 * len(backbone) > goals.conditions:
        own = None if near is None else near[found]
        for power in POWERS[: 1 + (choose in ("least-largest", "farthest"))]:
            best[found] = settle(goals.take(found), backbone, best[found], choose, own, ROUNDS[1], power)
    return best, found


def _polish(goals: Goals, backbone: Backbone, bends: Array) -> None:
    """Take what is left of the miss where steps of a search ended, in place."""
    residue = goals.off(bends, backbone)
    rows = np.flatnonzero((residue > 1e-14) & (residue < 1e-6))
    if len(rows):
        these = goals.take(rows)
        closer = descend(these, backbone, bends[rows], steps=150, near=True)
        better = (these.off(closer, backbone) < residue[rows]) & (excess(closer, backbone) <= 0)
        bends[rows[better]] = closer[better]

"""Inverse kinematics of any number of sections: damped least squares from several starts, then a choice."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import POWERS, Choice, penalty, settle, solved
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.least_squares import clamped, descend, excess, reached
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH, TOLERANCE, Inverse
from contarm_sim.kinematics.inverse.seeds import spread

STARTS = 8
"""Starts of every target; the choice is among what they lead to."""

MORE = (8, 16, 32, 64, 128)
"""Further starts of a target that those before it left unsolved."""

ROUNDS = (6, 8)
"""Most steps along a surface of solutions, down to the choice: of all solutions, then of the best."""

_BLOCK = 4096  # targets at a time
_SAME = 1e-6  # solutions nearer to each other are one [rad]
_STRICT = 100.0  # what an excess over a limit counts as where a target cannot be reached


def solve_general(
    goals: Goals,
    backbone: Backbone,
    choose: Choice = "least-bend",
    near: Array | None = None,
    seeds: Array | None = None,
    starts: int = STARTS,
) -> Inverse:
    """Return one answer for each goal, of any number of sections and any goals.

    Where there are as many conditions as bends or more, solutions are isolated, and those among which the choice is
    made are those that the starts led to, not surely all. `farthest` and `least-largest` are settled by a high power in
    place of the largest.

    Args:
        near: bends [rad], shape (n, S, 2), for the choice `nearest`; a start in any case.
        seeds: other starts [rad], shape (n, K, S, 2); NaN for none.
        starts: how many of each goal come first; the choice is among what they lead to.
    """
    parts = []
    for first in range(0, len(goals), _BLOCK):
        block = slice(first, first + _BLOCK)
        own, more = None if near is None else near[block], None if seeds is None else seeds[block]
        parts.append(_solve(goals.take(block), backbone, choose, own, more, starts))
    if not parts:
        none = np.zeros(0)
        return Inverse(np.zeros((0, len(backbone), 2)), none, none, none.astype(bool), none.astype(np.intp))
    columns = ("bends", "miss", "angle_miss", "reachable", "solutions")
    return Inverse(*(np.concatenate([getattr(part, name) for part in parts]) for name in columns))


def _solve(
    goals: Goals,
    backbone: Backbone,
    choose: Choice,
    near: Array | None,
    seeds: Array | None,
    starts: int,
) -> Inverse:
    count, size = len(goals), len(backbone)
    given = [np.broadcast_to(spread(starts, backbone), (count, starts, size, 2))]
    if near is not None:
        given.append(near[:, None])
    if seeds is not None:
        given.append(seeds)
    bends, good = _from_starts(goals, backbone, np.concatenate(given, axis=1))
    best, found = _chosen(goals, backbone, bends, good, choose, near)
    first = starts
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
        closer = new_found | (_worst(these, backbone, new) < _worst(these, backbone, best[rows]))
        best[rows[closer]], found[rows] = new[closer], new_found
    _polish(goals, backbone, best)
    _approach(goals, backbone, best, ~found)
    return _answer(goals, backbone, best, bends, good)


def _from_starts(goals: Goals, backbone: Backbone, start: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return what K starts lead to, shape (n, K, S, 2), and which of it is a solution, shape (n, K)."""
    count, each = start.shape[:2]
    flat = start.reshape(count * each, *start.shape[2:])
    rows = np.flatnonzero(np.isfinite(flat).all(axis=(-1, -2)))
    owner = goals.take(rows // each)
    found = descend(owner, backbone, flat[rows])
    good = np.zeros(count * each, dtype=bool)
    good[rows] = solved(owner, backbone, found)
    out = np.zeros_like(flat)
    out[rows] = clamped(found, backbone)
    return out.reshape(start.shape), good.reshape(count, each)


def _chosen(
    goals: Goals, backbone: Backbone, bends: Array, good: NDArray[np.bool_], choose: Choice, near: Array | None
) -> tuple[Array, NDArray[np.bool_]]:
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
        cost[unsolved, k] = _worst(goals.take(unsolved), backbone, bends[unsolved, k])
    best, found = bends[np.arange(len(bends)), cost.argmin(axis=1)], np.asarray(good.any(axis=1))
    if 2 * len(backbone) > goals.conditions:
        own = None if near is None else near[found]
        for power in POWERS[: 1 + (choose in ("least-largest", "farthest"))]:
            best[found] = settle(goals.take(found), backbone, best[found], choose, own, ROUNDS[1], power)
    return best, found


def _worst(goals: Goals, backbone: Backbone, bends: Array) -> Array:
    miss, angle = reached(goals, backbone, bends)
    return np.asarray(np.hypot(miss, ANGLE_LENGTH * backbone.length * angle))


def _polish(goals: Goals, backbone: Backbone, bends: Array) -> None:
    """Take what is left of the miss where steps of a search ended, in place."""
    residue = _worst(goals, backbone, bends)
    rows = np.flatnonzero((residue > 1e-14 * backbone.length) & (residue < 1e-6 * backbone.length))
    if len(rows):
        these = goals.take(rows)
        closer = descend(these, backbone, bends[rows], steps=150, near=True)
        better = (_worst(these, backbone, closer) < residue[rows]) & (excess(closer, backbone) <= 0)
        bends[rows[better]] = closer[better]


def _approach(goals: Goals, backbone: Backbone, bends: Array, rows: NDArray[np.bool_]) -> None:
    """Lead bends of targets that cannot be reached as near as their limits let them, in place."""
    if rows.any():
        these = goals.take(rows)
        near = clamped(descend(these, backbone, bends[rows], limited=_STRICT, steps=400, stalled=1e-12), backbone)
        closer = _worst(these, backbone, near) < _worst(these, backbone, bends[rows])
        bends[rows] = np.where(closer[:, None, None], near, bends[rows])


def _answer(goals: Goals, backbone: Backbone, best: Array, bends: Array, good: NDArray[np.bool_]) -> Inverse:
    miss, angle = reached(goals, backbone, best)
    within = np.maximum(miss, ANGLE_LENGTH * backbone.length * angle) <= TOLERANCE * backbone.length
    if 2 * len(backbone) > goals.conditions:
        solutions = np.where(within, -1, 0)
    else:
        solutions = np.where(within, np.maximum(_distinct(bends, good), 1), 0)
    return Inverse(best, miss, angle, within, solutions.astype(np.intp))


def _distinct(bends: Array, good: NDArray[np.bool_]) -> Array:
    """Return how many different solutions each goal has among its own, shape (n,)."""
    new = good.copy()
    for k in range(1, bends.shape[1]):
        apart = np.abs(bends[:, :k] - bends[:, k : k + 1]).max(axis=(-1, -2)) > _SAME
        new[:, k] &= (apart | ~good[:, :k]).all(axis=1)
    return new.sum(axis=1)

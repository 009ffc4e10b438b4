"""Damped least squares (Levenberg, Marquardt) of many problems at once, on analytic Jacobians.

The step is J' (J J' + damping)^-1 residual: the shortest that does it, where there are more bends than conditions.
Bends run free, or are led inside their limits by one more residual a section, what its bend angle exceeds its limit by:
to clamp them in every step costs many solutions.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import angles_of
from contarm_sim.kinematics.inverse.result import Index

Terms = Callable[[Array, Index], tuple[Array, Array]]
"""Residuals, shape (k, m), and how they fall by the unknowns, (k, m, d): of unknowns of the problems given, (k,)."""

ROUNDED = 1e-15
"""Residual, free of units, below which no step is worth taking."""

LIMITED = 0.3
"""What an excess over a limit of 1 rad counts as, beside the residual: much less or more costs solutions."""

STRICT = 100.0
"""The same where a target cannot be reached, and the limits must hold."""

_MARGIN = 2e-12  # bends are led this far inside their limits [rad]
_FIRST, _NEAR, _LEAST, _MOST = 1e-3, 1e-7, 1e-13, 1e6  # damping, against squares of Jacobians of about 1


def descend(
    goals: Goals,
    backbone: Backbone,
    start: Array,
    limited: float = LIMITED,
    steps: int = 60,
    near: bool = False,
    stalled: float = 1e-3,
) -> Array:
    """Return bends [rad], shape (n, S, 2), that damped least squares lead to from `start`, of the same shape.

    Args:
        limited: what an excess over a limit [rad] counts as beside the residual; 0 leaves bends free.
        steps: most of them.
        near: the start is near a solution, so little damping does.
        stalled: where ten steps take off less than this share of the square of the residual, the search ends.
    """

    def terms(bends: Array, rows: Index) -> tuple[Array, Array]:
        own = goals if len(rows) == len(goals) else goals.take(rows)
        residual, slopes = own.terms(bends, backbone)
        if limited > 0:
            beyond, outward = _beyond(bends, backbone)
            residual = np.concatenate([residual, -limited * beyond], axis=-1)
            slopes = np.concatenate([slopes, limited * outward], axis=-2)
        return residual, slopes

    return damped(terms, start, steps, _NEAR if near else _FIRST, stalled)


def damped(
    terms: Terms,
    start: Array,
    steps: int,
    damping: float = _FIRST,
    stalled: float = 1e-3,
    enough: float = ROUNDED,
    longest: float = np.inf,
    within: Callable[[Array], Array] | None = None,
) -> Array:
    """Return unknowns, shape (n, ...), that lead residuals down from `start`, of the same shape.

    Args:
        terms: the problems.
        steps: most of them.
        damping: the first.
        stalled: where ten steps take off less than this share of the square of the residual, the search ends.
        enough: residual that is small enough.
        longest: length of the longest step.
        within: brings unknowns that a step leads to back to what they may be.
    """
    out = np.array(start)
    rows = np.arange(len(out))
    x, dampings = out.copy(), np.full(len(out), damping)
    residual, slopes = terms(x, rows)
    cost = np.einsum("ni,ni->n", residual, residual)
    before = cost.copy()
    for step in range(steps):
        if not len(rows):
            break
        move = _step(residual, slopes, dampings)
        if longest < np.inf:
            move *= longest / np.maximum(np.linalg.norm(move, axis=-1, keepdims=True), longest)
        trial = x + move.reshape(x.shape)
        if within is not None:
            trial = within(trial)
        new_residual, new_slopes = terms(trial, rows)
        new_cost = np.einsum("ni,ni->n", new_residual, new_residual)
        better = new_cost < cost
        x[better], cost[better] = trial[better], new_cost[better]
        residual[better], slopes[better] = new_residual[better], new_slopes[better]
        dampings = np.clip(np.where(better, 0.1 * dampings, 10 * dampings), _LEAST, _MOST)
        done = (cost < enough**2) | (~better & ((dampings >= _MOST) | (cost < 1e-26)))
        if step % 10 == 9:
            done |= cost > (1 - stalled) * before
            before = cost.copy()
        if done.any():
            out[rows[done]] = x[done]
            left = ~done
            rows, x, dampings, before = rows[left], x[left], dampings[left], before[left]
            residual, slopes, cost = residual[left], slopes[left], cost[left]
    out[rows] = x
    return out


def _step(residual: Array, slopes: Array, damping: Array) -> Array:
    square = slopes @ slopes.swapaxes(-1, -2)
    diagonal = np.arange(square.shape[-1])
    square[:, diagonal, diagonal] += damping[:, None]
    return np.asarray((slopes.swapaxes(-1, -2) @ np.linalg.solve(square, residual[..., None]))[..., 0])


def _beyond(bends: Array, backbone: Backbone) -> tuple[Array, Array]:
    """Return what bend angles exceed their limits by, shape (n, S), and its slopes by bends, shape (n, S, 2 S)."""
    count, size = bends.shape[:2]
    angles = angles_of(bends)
    beyond = np.maximum(angles - (np.array(backbone.limits) - _MARGIN), 0.0)
    outward = np.zeros((count, size, size, 2))
    own = np.arange(size)
    outward[:, own, own] = np.where(beyond > 0, 1 / np.maximum(angles, 1e-300), 0.0)[..., None] * bends
    return beyond, outward.reshape(count, size, 2 * size)

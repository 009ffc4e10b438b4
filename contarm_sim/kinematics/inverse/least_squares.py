"""Damped least squares (Levenberg, Marquardt) of many tips at once, on the analytic Jacobian.

The step is J' (J J' + damping)^-1 residual: the shortest that does it, where there are more bends than conditions.
Bends run free, or are led inside their limits by one more residual a section, what its bend angle exceeds its limit by:
to clamp them in every step costs many solutions.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH
from contarm_sim.kinematics.inverse.tips import tips_and_jacobians

ROUNDED = 1e-15
"""Residual, free of units, below which no step is worth taking."""

LIMITED = 0.3
"""What an excess over a limit of 1 rad counts as, beside the residual: much less or more costs solutions."""

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
    out = np.array(start)
    rows = np.arange(len(out))
    bends, damping = out.copy(), np.full(len(out), _NEAR if near else _FIRST)
    residual, slopes = _evaluate(goals, backbone, bends, limited)
    cost = np.einsum("ni,ni->n", residual, residual)
    before = cost.copy()
    for step in range(steps):
        trial = bends + _step(residual, slopes, damping).reshape(bends.shape)
        new_residual, new_slopes = _evaluate(goals, backbone, trial, limited)
        new_cost = np.einsum("ni,ni->n", new_residual, new_residual)
        better = new_cost < cost
        bends[better], cost[better] = trial[better], new_cost[better]
        residual[better], slopes[better] = new_residual[better], new_slopes[better]
        damping = np.clip(np.where(better, 0.1 * damping, 10 * damping), _LEAST, _MOST)
        done = (cost < ROUNDED**2) | (~better & ((damping >= _MOST) | (cost < 1e-26)))
        if step % 10 == 9:
            done |= cost > (1 - stalled) * before
            before = cost.copy()
        if done.any():
            out[rows[done]] = bends[done]
            left = ~done
            rows, bends, damping, before = rows[left], bends[left], damping[left], before[left]
            residual, slopes, cost, goals = residual[left], slopes[left], cost[left], goals.take(left)
            if not len(rows):
                break
    out[rows] = bends
    return out


def turning(goals: Goals, backbone: Backbone, bends: Array, most: float = 0.1) -> Array:
    """Return steps of bends [rad], shape (n, S, 2), that turn tips towards goals, in place to first order.

    Of two sections, whose positions leave one parameter free; no step is longer than `most` [rad].
    """
    _, rotation, jacobian = tips_and_jacobians(bends, backbone)
    free = np.linalg.svd(jacobian[:, :3])[2][:, -1]
    turn = goals.turn(rotation)
    assert turn is not None
    rate = (goals.rows(jacobian, rotation, backbone.length)[:, 3:] @ free[..., None])[..., 0] / ANGLE_LENGTH
    step = (rate * turn).sum(axis=-1) / ((rate**2).sum(axis=-1) + 1e-6)
    return np.asarray((np.clip(step, -most, most)[:, None] * free).reshape(bends.shape))


def reached(goals: Goals, backbone: Backbone, bends: Array) -> tuple[Array, Array]:
    """Return the distances [m] and angles [rad] that bends miss goals by, each of shape (n,)."""
    position, rotation, _ = tips_and_jacobians(bends, backbone)
    return goals.misses(position, rotation)


def excess(bends: Array, backbone: Backbone) -> Array:
    """Return what bend angles exceed their limits by, at most over sections [rad], shape (...); below 0 inside."""
    angles = np.hypot(bends[..., 0], bends[..., 1])
    return np.asarray((angles - np.array(backbone.limits)).max(axis=-1))


def clamped(bends: Array, backbone: Backbone) -> Array:
    """Return bends with those beyond their limits shortened to them."""
    angles = np.hypot(bends[..., 0], bends[..., 1])
    return np.asarray(bends * np.minimum(1.0, np.array(backbone.limits) / np.maximum(angles, 1e-300))[..., None])


def _step(residual: Array, slopes: Array, damping: Array) -> Array:
    square = slopes @ slopes.swapaxes(-1, -2)
    diagonal = np.arange(square.shape[-1])
    square[:, diagonal, diagonal] += damping[:, None]
    return np.asarray((slopes.swapaxes(-1, -2) @ np.linalg.solve(square, residual[..., None]))[..., 0])


def _evaluate(goals: Goals, backbone: Backbone, bends: Array, limited: float) -> tuple[Array, Array]:
    position, rotation, jacobian = tips_and_jacobians(bends, backbone)
    residual = goals.residual(position, rotation, backbone.length)
    slopes = goals.rows(jacobian, rotation, backbone.length)
    if limited > 0:
        beyond, outward = _beyond(bends, backbone)
        residual = np.concatenate([residual, -limited * beyond], axis=-1)
        slopes = np.concatenate([slopes, limited * outward], axis=-2)
    return residual, slopes


def _beyond(bends: Array, backbone: Backbone) -> tuple[Array, Array]:
    """Return what bend angles exceed their limits by, shape (n, S), and its slopes by bends, shape (n, S, 2 S)."""
    count, size = bends.shape[:2]
    angles = np.hypot(bends[..., 0], bends[..., 1])
    beyond = np.maximum(angles - (np.array(backbone.limits) - _MARGIN), 0.0)
    outward = np.zeros((count, size, size, 2))
    own = np.arange(size)
    outward[:, own, own] = np.where(beyond > 0, 1 / np.maximum(angles, 1e-300), 0.0)[..., None] * bends
    return beyond, outward.reshape(count, size, 2 * size)

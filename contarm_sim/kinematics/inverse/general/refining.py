"""Down to the optimum of a choice that a solution lies next to, where there are more bends than conditions.

Newton's method on the surface of solutions: with N the null space of the Jacobian J, and y the forces that hold tips,
the step N c goes down by the curvature N' (F'' - (J' y)') N, F what the choice makes least, `smooth`. Negative
curvatures count as positive ones. Each step is led back onto the surface; its width goes to 0 meanwhile.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import Choice, penalty
from contarm_sim.kinematics.inverse.general import smooth
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import angles_of

STEPS = 22
"""Most steps down to an optimum."""

_FIRST = {"nearest": 1e-6, "least-bend": 0.3, "least-largest": 1.0, "farthest": 1.0}  # widths [rad]
_LAST = {"nearest": 1e-6, "least-bend": 1e-8, "least-largest": 1e-6, "farthest": 1e-6}
_SMALL = 1e-3  # width from which it narrows faster
_LONGEST, _SHORTEST = 0.5, 1e-7  # steps [rad]
_DIFFERENCE = 1e-6  # for the curvature of the surface [rad]
_DAMPING = 1e-13
_FLAT = 0.1  # least curvature [1/rad]
_SETTLED = 1e-9  # gain of a step that is no more [rad]


def refine(
    goals: Goals, backbone: Backbone, bends: Array, choose: Choice, near: Array | None, steps: int = STEPS
) -> Array:
    """Return solutions of the least `penalty` next to others [rad], shape (n, S, 2); never worse ones."""
    best, least = bends.copy(), penalty(bends, backbone, choose, near)
    rows, at = np.arange(len(bends)), bends.copy()
    width, most = np.full(len(bends), _FIRST[choose]), np.full(len(bends), _LONGEST)
    for _ in range(steps):
        if not len(rows):
            break
        these, ref = goals.take(rows), None if near is None else near[rows]
        step, expected = _step(these, backbone, at, choose, ref, width)
        size = np.sqrt((step**2).sum(axis=(-1, -2)))
        moved = at + np.minimum(1.0, most / np.maximum(size, 1e-300))[:, None, None] * step
        moved, off = _back(these, backbone, moved, choose, width)
        gain = smooth.value(at, backbone, choose, ref, width) - smooth.value(moved, backbone, choose, ref, width)
        better = (gain > -1e-12) & (off < 1e-6)
        at[better] = moved[better]
        cost = penalty(at, backbone, choose, ref)
        new = better & (cost < least[rows]) & these.solved(at, backbone)
        best[rows[new]], least[rows[new]] = at[new], cost[new]
        done = (width <= _LAST[choose]) & better & (expected < _SETTLED)
        most = np.where(better, np.maximum(most, 2 * np.minimum(size, _LONGEST)), 0.25 * np.minimum(most, size))
        width = np.where(better, np.maximum(_narrower(width, choose), _LAST[choose]), width)
        left = ~done & (most > _SHORTEST)
        rows, at, width, most = rows[left], at[left], width[left], most[left]
    return best


def _narrower(width: Array, choose: Choice) -> Array:
    return np.where(width > _SMALL, 0.2 if choose == "least-bend" else 0.6, 0.1) * width


def _step(
    goals: Goals, backbone: Backbone, bends: Array, choose: Choice, near: Array | None, width: Array
) -> tuple[Array, Array]:
    """Return Newton's steps [rad], shape (n, S, 2), and what they are to gain [rad], shape (n,)."""
    count, size = len(bends), 2 * bends.shape[1]
    J = goals.terms(bends, backbone)[1]
    free = np.linalg.svd(J)[2][:, goals.conditions :]
    down = smooth.slopes(bends, backbone, choose, near, width)
    loose = _loose(bends, choose, width)
    square = _damped((J * loose) @ J.swapaxes(-1, -2))
    force = np.linalg.solve(square, (J * loose) @ down.reshape(count, size, 1))
    dual = (J.swapaxes(-1, -2) @ force).reshape(bends.shape)
    own = smooth.curvature(bends, backbone, choose, width, dual).reshape(count, size, size)
    each = free.shape[1]
    beside = (bends[:, None] + _DIFFERENCE * free.reshape(count, each, -1, 2)).reshape(count * each, -1, 2)
    again = goals.take(np.repeat(np.arange(count), each)).terms(beside, backbone)[1].reshape(count, each, *J.shape[1:])
    bent = ((again - J[:, None]).swapaxes(-1, -2) @ force[:, None])[..., 0] / _DIFFERENCE
    H = free @ own @ free.swapaxes(-1, -2) - free @ bent.swapaxes(-1, -2)
    curved, ways = np.linalg.eigh(0.5 * (H + H.swapaxes(-1, -2)))
    along = ways.swapaxes(-1, -2) @ (free @ down.reshape(count, size, 1))
    c = along[..., 0] / np.maximum(np.abs(curved), _FLAT)
    step = -(free.swapaxes(-1, -2) @ (ways @ c[..., None]))
    return step.reshape(bends.shape), np.asarray((along[..., 0] * c).sum(axis=-1))


def _back(goals: Goals, backbone: Backbone, bends: Array, choose: Choice, width: Array) -> tuple[Array, Array]:
    """Return solutions next to bends, and how far they are off, free of units; straight sections stay straight."""
    loose = _loose(bends, choose, width)
    off, size = np.zeros(len(bends)), bends.shape
    for last in (False, False, True):
        residual, J = goals.terms(bends, backbone)
        off = np.sqrt((residual**2).sum(axis=-1))
        if last or (off < 1e-14).all():
            break
        square = _damped((J * loose) @ J.swapaxes(-1, -2))
        bends = bends + (loose.swapaxes(-1, -2) * (J.swapaxes(-1, -2) @ np.linalg.solve(square, residual[..., None])))[
            ..., 0
        ].reshape(size)
    return bends, off


def _loose(bends: Array, choose: Choice, width: Array) -> Array:
    """Return how easily each bend gives way, shape (n, 1, 2 S)."""
    if choose != "least-bend":
        return np.ones((len(bends), 1, 2 * bends.shape[1]))
    s = np.hypot(angles_of(bends), width[:, None])
    return np.repeat(s / s.max(axis=-1, keepdims=True), 2, axis=-1)[:, None, :]


def _damped(square: Array) -> Array:
    diagonal = np.arange(square.shape[-1])
    square[:, diagonal, diagonal] += _DAMPING
    return square

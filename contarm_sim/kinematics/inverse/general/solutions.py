"""All solutions of one target, as far as random starts find them; families of one parameter traced from end to end.

A curve of solutions is followed along the null vector of its Jacobian, with a step back onto it each time, until it
closes or leaves the limits.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import distinct, penalty
from contarm_sim.kinematics.inverse.general.free import along
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.general.starts import spread
from contarm_sim.kinematics.inverse.goals import Goals

_STARTS = 64
_STRIDE, _SHORTEST = 0.1, 1e-3  # along a curve; the shortest decide where it ends [rad]
_LONGEST = 600  # strides
_CLOSED = 0.7  # strides: nearer to its first point than this, a curve closes


def samples(goal: Goals, backbone: Backbone, points: int) -> list[Array]:
    """Return the solutions of one goal as `targets.solve_all` does."""
    start = spread(_STARTS, backbone)
    goals = goal.take(np.zeros(_STARTS, dtype=int))
    found = descend(goals, backbone, start)
    found = found[goals.solved(found, backbone)]
    found = found[np.argsort(penalty(found, backbone, "least-bend"))]
    free = 2 * len(backbone) - goal.conditions
    if free > 1:
        return [found[:points]] if len(found) else []
    if free < 1:
        return [one[None] for one in found[distinct(found[None], np.ones((1, len(found)), dtype=bool))[0]]]
    curves: list[Array] = []
    for one in found:
        if not any(_distance(curve, one) < 2 * _STRIDE for curve in curves):
            curve = _trace(goal, backbone, one)
            if not any(_distance(other, curve[0]) < _STRIDE for other in curves):
                curves.append(curve)
    return [curve[np.unique(np.linspace(0, len(curve) - 1, points).round().astype(int))] for curve in curves]


def _distance(curve: Array, bends: Array) -> float:
    return float(np.sqrt(((curve - bends) ** 2).sum(axis=(-1, -2))).min())


def _trace(goal: Goals, backbone: Backbone, bends: Array) -> Array:
    """Return the curve of solutions through one of them, shape (K, S, 2): closed, or from limit to limit."""
    forth = _follow(goal, backbone, bends, 1.0)
    if len(forth) > 2 and np.linalg.norm(forth[-1] - bends) < _CLOSED * _STRIDE:
        return forth
    return np.concatenate([_follow(goal, backbone, bends, -1.0)[:0:-1], forth])


def _follow(goal: Goals, backbone: Backbone, bends: Array, sign: float) -> Array:
    curve, ahead, stride = [bends], sign * along(goal, backbone, bends[None])[0], _STRIDE
    while len(curve) < _LONGEST and stride > _SHORTEST:
        moved = descend(goal, backbone, (bends + stride * ahead)[None], limited=0.0, steps=6, near=True)
        if not goal.solved(moved, backbone)[0] or np.linalg.norm(moved[0] - bends) > 2 * stride:
            stride *= 0.3
            continue
        bends = moved[0]
        curve.append(bends)
        if len(curve) > 3 and np.linalg.norm(bends - curve[0]) < _CLOSED * _STRIDE:
            break
        tangent = along(goal, backbone, bends[None])[0]
        ahead = tangent if (tangent * ahead).sum() > 0 else -tangent
    return np.array(curve)

"""How to settle on the best solution that one leads to, where there are more bends than conditions.

Solutions then form a surface. `settle` goes down along it: to first order the nearest solution to a reference, in
weights W of the sections, is

    b = reference + W^-1 J' (J W^-1 J')^-1 (residual + J (b - reference))

and any rule that grows by bend angles is such a distance from the straight arm, in weights that follow the bends.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import Choice, penalty
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import angles_of

POWERS = (8, 40)
"""The largest of some numbers is taken for a root of the sum of such powers, the second one to come closer."""

_LIGHTEST = 1e-3  # least weight of a section beside the heaviest
_DAMPING = 1e-12


def settle(
    goals: Goals,
    backbone: Backbone,
    bends: Array,
    choose: Choice,
    near: Array | None,
    rounds: int,
    power: int = POWERS[0],
) -> Array:
    """Return solutions with a lower `penalty` that others, shape (n, S, 2), lead to; they stay where none is found."""
    bends, share = bends.copy(), np.full(len(bends), 0.5)
    least = penalty(bends, backbone, choose, near)
    rows = np.arange(len(bends))
    for _ in range(rounds):
        if not len(rows):
            break
        these, own, ref = goals.take(rows), bends[rows], None if near is None else near[rows]
        moved = own + share[rows, None, None] * (_toward(these, backbone, own, choose, ref, power) - own)
        moved = descend(these, backbone, moved, steps=8, near=True)
        found = penalty(moved, backbone, choose, ref)
        gain = least[rows] - found
        better = (gain > 0) & these.solved(moved, backbone)
        bends[rows[better]], least[rows[better]] = moved[better], found[better]
        share[rows] = np.where(better, np.minimum(1.0, 1.5 * share[rows]), 0.25 * share[rows])
        rows = rows[np.where(better, gain > 1e-4, share[rows] > 0.01)]
    return bends


def _toward(goals: Goals, backbone: Backbone, bends: Array, choose: Choice, near: Array | None, power: int) -> Array:
    """Return the solutions, to first order, that are nearest to the reference of a choice."""
    count = len(bends)
    residual, slopes = goals.terms(bends, backbone)
    reference = np.zeros_like(bends) if choose != "nearest" or near is None else near
    loose = np.repeat(1 / _weights(bends, backbone, choose, power), 2, axis=-1)[:, None, :]
    square = (slopes * loose) @ slopes.swapaxes(-1, -2)
    diagonal = np.arange(square.shape[-1])
    square[:, diagonal, diagonal] += _DAMPING
    off = residual + (slopes @ (bends - reference).reshape(count, -1, 1))[..., 0]
    step = (slopes * loose).swapaxes(-1, -2) @ np.linalg.solve(square, off[..., None])
    return np.asarray(reference + step.reshape(bends.shape))


def _weights(bends: Array, backbone: Backbone, choose: Choice, power: int) -> Array:
    """Return weights of the sections, 1 for the heaviest, shape (n, S): the slope of a rule over the bend angle."""
    angles = np.maximum(angles_of(bends), 1e-6)
    if choose == "nearest":
        return np.ones_like(angles)
    if choose == "least-bend":
        weights = 1 / angles
    else:
        limits = np.array(backbone.limits)
        large = angles + (limits.max() - limits) if choose == "farthest" else angles
        weights = (large / large.max(axis=-1, keepdims=True)) ** (power - 1) / angles
    return np.asarray(np.maximum(weights / weights.max(axis=-1, keepdims=True), _LIGHTEST))

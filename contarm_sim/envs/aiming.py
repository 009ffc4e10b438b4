"""Bends of several sections whose tip is at a point: damped least squares from the bends that the arm has.

There are more bends than coordinates of a point; steps are the shortest that lead to it, so the arm ends near where it
begins. The tip is the simulated chain's at rest without load.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.envs.actions import shortened
from contarm_sim.envs.ranges import scattered_bends
from contarm_sim.kinematics import arc, sections
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm

CLOSE = 1e-6
"""Distance from the point that counts as none [lengths]."""

STEPS = 40
"""Most steps from one start."""

STARTS = 24
"""Further starts for points that the first one does not lead to."""

_DAMPING = 1e-9  # of squares of the tip's way by bends [lengths^2/rad^2]
_LONGEST = 0.5  # longest step [rad]


def nearest_bends(targets: Array, near: Array, arm: Arm) -> Array:
    """Return bends to 170 deg [rad], shape (B, 2 S), whose tips are nearest to points; of several, about those near.

    Args:
        targets: points in the base frame [m], shape (B, 3).
        near: bends to begin from [rad], shape (B, 2 S).
    """
    bends = _descend(targets, near, arm)
    left = np.flatnonzero(_miss(targets, bends, arm) > CLOSE * arm.length)
    if not len(left):
        return bends
    starts = scattered_bends(len(arm.sections), STARTS)
    starts = starts * np.sqrt((np.arange(STARTS) + 0.5) / STARTS)[:, None]
    count, own = len(left), np.repeat(targets[left], STARTS, axis=0)
    found = _descend(own, np.tile(starts, (count, 1)), arm)
    miss = _miss(own, found, arm).reshape(count, STARTS)
    far = np.linalg.norm(found.reshape(count, STARTS, -1) - near[left, None], axis=-1)
    # Where some reach the point, the nearest of these; else what comes nearest to the point.
    cost = np.where(miss <= CLOSE * arm.length, far, 1e3 * (1 + miss / arm.length))
    best = cost.argmin(axis=1)
    new, better = found.reshape(count, STARTS, -1)[np.arange(count), best], miss[np.arange(count), best]
    closer = better < _miss(targets[left], bends[left], arm)
    bends[left[closer]] = new[closer]
    return bends


def _descend(targets: Array, start: Array, arm: Arm) -> Array:
    """Return what damped steps lead to; those that lead away are taken back."""
    bends, damping = shortened(start), np.full(len(start), _DAMPING)
    backbone = shape.backbone(arm, chained=True, limits=arc.LARGEST_BEND)
    miss = _miss(targets, bends, arm)
    for _ in range(STEPS):
        rows = np.flatnonzero((miss > 0.1 * CLOSE * arm.length) & (damping < 1.0))
        if not len(rows):
            break
        own = bends[rows]
        slope = sections.jacobian(shape.bends_of(own, arm), backbone, check=False)[:, :3] / arm.length
        off = (targets[rows] - shape.chain_tip(own, arm)) / arm.length
        gram = slope @ slope.swapaxes(-1, -2) + damping[rows, None, None] * np.eye(3)
        step = (slope.swapaxes(-1, -2) @ np.linalg.solve(gram, off[..., None]))[..., 0]
        longest = np.linalg.norm(step, axis=-1, keepdims=True)
        trial = shortened(own + step * np.minimum(1.0, _LONGEST / np.maximum(longest, _LONGEST)))
        found = _miss(targets[rows], trial, arm)
        better = found < miss[rows]
        bends[rows[better]], miss[rows[better]] = trial[better], found[better]
        damping[rows] = np.where(
            better, np.maximum(0.1 * damping[rows], _DAMPING), np.maximum(10 * damping[rows], 1e-4)
        )
    return bends


def _miss(targets: Array, bends: Array, arm: Arm) -> Array:
    return np.asarray(np.linalg.norm(targets - shape.chain_tip(bends, arm), axis=-1))

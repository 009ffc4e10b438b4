"""Bends of several sections whose tip is at a point: damped least squares from the bends that the arm has.

There are more bends than coordinates of a point; steps are the shortest that lead to it, so the arm ends near where it
begins. Where the muscles do not hold that, other solutions are sought from other starts. The tip is the simulated
chain's at rest without load.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.envs.actions import Actions, shortened
from contarm_sim.kinematics import arc, sections
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.general.least_squares import damped
from contarm_sim.kinematics.inverse.general.starts import spread
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm

CLOSE = 1e-6
"""Distance from the point that counts as none [lengths]."""

STEPS = 40
"""Most steps from one start."""

STARTS = 60
"""Further starts for points that the first one does not lead to by bends that the muscles hold."""

_UNHELD, _MISSED = 1e3, 1e6  # what is worse than any distance of bends, and worse still


def nearest_bends(targets: Array, near: Array, actions: Actions) -> Array:
    """Return bends to 170 deg [rad], shape (B, 2 S), whose tips are at points, or as near to them as was found.

    Of several solutions one that the muscles hold, about the nearest to bends that are given.

    Args:
        targets: points in the base frame [m], shape (B, 3).
        near: bends to begin from [rad], shape (B, 2 S).
        actions: what drives the arm.
    """
    arm, bends = actions.arm, _descend(targets, near, actions.arm)
    cost = _cost(targets, near, bends, actions)
    left = np.flatnonzero(cost >= _UNHELD)
    if not len(left):
        return bends
    starts = spread(STARTS, shape.backbone(arm)).reshape(STARTS, -1)  # over what muscles can take the lengths of
    own, ref = (np.repeat(array[left], STARTS, axis=0) for array in (targets, near))
    found = _descend(own, np.tile(starts, (len(left), 1)), arm)
    costs = _cost(own, ref, found, actions).reshape(len(left), STARTS)
    rows, best = np.arange(len(left)), costs.argmin(axis=1)
    better = costs[rows, best] < cost[left]
    bends[left[better]] = found.reshape(len(left), STARTS, -1)[rows, best][better]
    return bends


def _cost(targets: Array, near: Array, bends: Array, actions: Actions) -> Array:
    """Return the way of the bends [rad], shape (B,), and more where no muscles hold them or the tip is not there."""
    far = np.linalg.norm(bends - near, axis=-1)
    miss = _miss(targets, bends, actions.arm) / actions.arm.length
    missed = np.where(miss > CLOSE, _MISSED * (1 + miss), 0.0)
    return np.asarray(far + missed + np.where(actions.hold(bends), 0.0, _UNHELD))


def _descend(targets: Array, start: Array, arm: Arm) -> Array:
    """Return what damped steps lead to; those that lead away are taken back."""
    backbone = shape.backbone(arm, chained=True, limits=arc.LARGEST_BEND)

    def terms(bends: Array, rows: Index) -> tuple[Array, Array]:
        slopes = sections.jacobian(shape.bends_of(bends, arm), backbone, check=False)[:, :3]
        return (targets[rows] - shape.chain_tip(bends, arm)) / arm.length, slopes / arm.length

    return damped(terms, shortened(start), STEPS, enough=0.1 * CLOSE, within=shortened)


def _miss(targets: Array, bends: Array, arm: Arm) -> Array:
    return np.asarray(np.linalg.norm(targets - shape.chain_tip(bends, arm), axis=-1))

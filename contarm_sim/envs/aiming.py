"""Bends of several sections whose tip is at a point: damped least squares from the bends that the arm has.

There are more bends than coordinates of a point; steps are the shortest that lead to it, so the arm ends near where it
begins. Where the muscles do not hold that, other solutions are sought from other starts. The tip is the simulated
chain's at rest without load.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.envs.actions import Actions, shortened
from contarm_sim.envs.ranges import scattered_bends
from contarm_sim.kinematics import arc, sections
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.general.least_squares import damped
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm

CLOSE = 1e-6
"""Distance from the point that counts as none [lengths]."""

STEPS = 40
"""Most steps from one start."""

STARTS = 60
"""Further starts for points that the first one does not lead to by bends that the muscles hold."""

_DAMPING = 1e-9  # of squares of the tip's way by bends, at first [1/rad^2]
_LONGEST = 0.5  # longest step [rad]
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
    starts = _starts(arm)
    own, ref = (np.repeat(array[left], STARTS, axis=0) for array in (targets, near))
    found = _descend(own, np.tile(starts, (len(left), 1)), arm)
    costs = _cost(own, ref, found, actions).reshape(len(left), STARTS)
    rows, best = np.arange(len(left)), costs.argmin(axis=1)
    better = costs[rows, best] < cost[left]
    bends[left[better]] = found.reshape(len(left), STARTS, -1)[rows, best][better]
    return bends


def _starts(arm: Arm) -> Array:
    """Return bends spread over what muscles of sections can take the lengths of [rad], shape (STARTS, 2 S)."""
    count = len(arm.sections)
    shares = np.modf(np.sqrt([17.0, 19.0, 23.0, 29.0, 31.0, 37.0])[:count] * np.arange(1, STARTS + 1)[:, None])[0]
    limits = np.minimum(np.array(shape.bend_limits(arm)) / arc.LARGEST_BEND, 1.0)
    return scattered_bends(count, STARTS) * np.repeat(limits * np.sqrt(shares), 2, axis=1)


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

    return damped(terms, shortened(start), STEPS, _DAMPING, enough=0.1 * CLOSE, longest=_LONGEST, within=shortened)


def _miss(targets: Array, bends: Array, arm: Arm) -> Array:
    return np.asarray(np.linalg.norm(targets - shape.chain_tip(bends, arm), axis=-1))

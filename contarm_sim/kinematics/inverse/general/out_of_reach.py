"""As near as bends come, within their limits, to what cannot be reached."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.general.least_squares import STRICT, descend
from contarm_sim.kinematics.inverse.general.starts import spread
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import clamped
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH
from contarm_sim.kinematics.inverse.tips import tips_and_jacobians

_POOL, _STARTS, _STEPS, _BLOCK = 1000, 8, 60, 512


def approached(goals: Goals, backbone: Backbone, bends: Array, steps: int = 400) -> Array:
    """Return the bends [rad], shape (n, S, 2), of a least miss next to some; it need not be the least of all."""
    near = clamped(descend(goals, backbone, bends, limited=STRICT, steps=steps, stalled=1e-12), backbone)
    closer = goals.off(near, backbone) < goals.off(bends, backbone)
    return np.where(closer[:, None, None], near, bends)


def nearest(goals: Goals, backbone: Backbone) -> Array:
    """Return the bends [rad], shape (n, S, 2), of the least miss known: from the nearest of a fixed set of poses."""
    pool = spread(_POOL, backbone)
    first = np.empty((len(goals), _STARTS), dtype=np.intp)
    for start in range(0, len(goals), _BLOCK):
        block = slice(start, start + _BLOCK)
        first[block] = np.argsort(_apart(goals.take(block), backbone, pool), axis=-1)[:, :_STARTS]
    owner = goals.take(np.repeat(np.arange(len(goals)), _STARTS))
    found = approached(owner, backbone, pool[first.ravel()], steps=_STEPS)
    best = owner.off(found, backbone).reshape(-1, _STARTS).argmin(axis=-1)
    return approached(goals, backbone, found.reshape(*first.shape, -1, 2)[np.arange(len(goals)), best])


def _apart(goals: Goals, backbone: Backbone, pool: Array) -> Array:
    """Return the squares of how far each pose of a set is from each goal, free of units, shape (n, poses)."""
    position, rotation, _ = tips_and_jacobians(pool, backbone)
    square = np.sum(((goals.position[:, None] - position) / backbone.length) ** 2, axis=-1)
    if goals.rotation is not None:
        cosine = 0.5 * (goals.rotation.reshape(-1, 9) @ rotation.reshape(-1, 9).T - 1)
    elif goals.direction is not None:
        cosine = goals.direction @ rotation[:, :, 2].T
    else:
        return np.asarray(square)
    return np.asarray(square + (ANGLE_LENGTH * np.arccos(np.clip(cosine, -1.0, 1.0))) ** 2)

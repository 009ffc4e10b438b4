"""The direction that one more bend than conditions leaves free: along a curve of solutions."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH


def along(goals: Goals, backbone: Backbone, bends: Array) -> Array:
    """Return unit steps of bends, shape (n, S, 2), that keep tips at their goals, to first order."""
    return np.asarray(np.linalg.svd(goals.terms(bends, backbone)[1])[2][:, -1].reshape(bends.shape))


def turning(goals: Goals, backbone: Backbone, bends: Array, most: float = 0.1) -> Array:
    """Return steps of bends [rad], shape (n, S, 2), that turn tips towards goals, in place to first order.

    Of two sections, whose positions leave one parameter free; no step is longer than `most` [rad].
    """
    free = along(Goals(goals.position), backbone, bends)
    residual, slopes = goals.terms(bends, backbone)
    turn = residual[:, 3:] / ANGLE_LENGTH
    rate = (slopes[:, 3:] @ free.reshape(len(free), -1, 1))[..., 0] / ANGLE_LENGTH
    step = (rate * turn).sum(axis=-1) / ((rate**2).sum(axis=-1) + 1e-6)
    return np.asarray(np.clip(step, -most, most)[:, None, None] * free)

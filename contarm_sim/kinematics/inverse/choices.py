"""Which of many solutions to choose: what each choice makes least."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.limits import angles_of

Choice = Literal["least-bend", "least-largest", "farthest", "nearest"]
CHOICES: tuple[Choice, ...] = get_args(Choice)


def penalty(bends: Array, backbone: Backbone, choose: Choice, near: Array | None = None) -> Array:
    """Return what a choice makes least [rad], shape (...): of bends of shape (..., S, 2).

    least-bend: the sum of bend angles. least-largest: the largest of them. farthest: the largest of bend angle minus
    limit, so that the least distance to a limit is largest. nearest: the distance to the bends `near`.
    """
    if choose == "nearest":
        return np.asarray(np.sqrt(((bends - np.asarray(near)) ** 2).sum(axis=(-1, -2))))
    angles = angles_of(bends)
    if choose == "least-bend":
        return np.asarray(angles.sum(axis=-1))
    return np.asarray((angles - np.array(backbone.limits) if choose == "farthest" else angles).max(axis=-1))

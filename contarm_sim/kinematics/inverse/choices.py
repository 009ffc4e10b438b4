"""Which of many solutions are distinct, and which of them to choose: what each choice makes least."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.limits import angles_of
from contarm_sim.kinematics.inverse.result import Bool

Choice = Literal["least-bend", "least-largest", "farthest", "nearest"]
CHOICES: tuple[Choice, ...] = get_args(Choice)

SAME = 1e-6
"""Bends that differ by less are one solution [rad]."""


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


def distinct(bends: Array, known: Bool) -> Bool:
    """Return which of the known of K solutions, (n, K), are the same as none before them; bends (n, K, S, 2)."""
    new = known.copy()
    for k in range(1, bends.shape[1]):
        apart = np.abs(bends[:, :k] - bends[:, k : k + 1]).max(axis=(-1, -2)) > SAME
        new[:, k] &= (apart | ~new[:, :k]).all(axis=1)
    return new

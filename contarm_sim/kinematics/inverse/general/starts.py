"""Where least squares start from: bends spread over the limits, the same ones for every target and in every call."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone

_RIM = 0.7  # every other one of the rest is bent more than this share of its limits: for targets that need it
_LARGEST, _GENTLE = 2.2, 12  # so many starts are bent less than this [rad]: they lead to solutions more often


def spread(count: int, backbone: Backbone, first: int = 0) -> Array:
    """Return bends [rad], shape (count, S, 2), evenly over the disks that limits bound, from a number `first` on."""
    size = len(backbone)
    draws = np.random.default_rng(0).random((first + count, size, 2))[first:]
    limits = np.array(backbone.limits)
    number = np.arange(first, first + count)[:, None]
    share = np.where((number >= _GENTLE) & (number % 2 == 1), _RIM + (1 - _RIM) * draws[..., 0], np.sqrt(draws[..., 0]))
    angle = share * np.where(number < _GENTLE, np.minimum(_LARGEST, limits), limits)
    plane = 2 * np.pi * draws[..., 1]
    return np.stack([angle * np.cos(plane), angle * np.sin(plane)], axis=-1)

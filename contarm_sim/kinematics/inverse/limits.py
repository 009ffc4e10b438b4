"""Bend angles and their limits."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone


def angles_of(bends: Array) -> Array:
    """Return bend angles [rad], shape (..., S), of bends (..., S, 2)."""
    return np.asarray(np.hypot(bends[..., 0], bends[..., 1]))


def excess(bends: Array, backbone: Backbone) -> Array:
    """Return what bend angles exceed their limits by, at most over sections [rad], shape (...); below 0 inside."""
    return np.asarray((angles_of(bends) - np.array(backbone.limits)).max(axis=-1))


def clamped(bends: Array, backbone: Backbone) -> Array:
    """Return bends with those beyond their limits shortened to them."""
    share = np.array(backbone.limits) / np.maximum(angles_of(bends), 1e-300)
    return np.asarray(bends * np.minimum(1.0, share)[..., None])

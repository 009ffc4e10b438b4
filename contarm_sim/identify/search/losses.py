"""Losses that large residuals weigh less in."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from contarm_sim.kinematics.arrays import Array

Loss = Literal["linear", "soft_l1", "huber", "cauchy"]
LOSSES: tuple[Loss, ...] = get_args(Loss)

THRESHOLD = 1.345
"""Residual over noise from which on it weighs less (Huber's: 95 % of the efficiency of least squares)."""


def rho(squares: Array, loss: Loss) -> Array:
    """Return a loss and its first two derivatives, shape (3, M), of squares of residuals over the threshold, (M,).

    Those of scipy's `least_squares`.
    """
    z = squares
    if loss == "soft_l1":
        t = 1 + z
        return np.array([2 * (np.sqrt(t) - 1), t**-0.5, -0.5 * t**-1.5])
    if loss == "huber":
        large = np.maximum(z, 1.0)
        far = np.array([2 * np.sqrt(large) - 1, large**-0.5, -0.5 * large**-1.5])
        return np.where(z <= 1, np.array([z, np.ones_like(z), np.zeros_like(z)]), far)
    if loss == "cauchy":
        return np.array([np.log1p(z), 1 / (1 + z), -1 / (1 + z) ** 2])
    return np.array([z, np.ones_like(z), np.zeros_like(z)])

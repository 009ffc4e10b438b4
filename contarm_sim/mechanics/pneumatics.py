"""The McKibben law of a pneumatic muscle (Chou and Hannaford 1996), from the paper's dimensions; its silicone."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm


def force(pressure: Any, length: Any, arm: Arm) -> Array:
    """Return the pulling force [N] of a muscle at a gauge pressure [Pa] and a length [m]; broadcasts.

    F = P (pi D0^2/4) (3 (1 - eps)^2/tan^2(alpha0) - 1/sin^2(alpha0)), eps the contraction from the rest length; a
    muscle contracted beyond `max_contraction` goes slack, it cannot push.
    """
    muscle = arm.muscle
    stretch = np.asarray(length, dtype=float) / arm.muscle_rest_length
    area = np.pi * muscle.diameter**2 / 4
    shape = 3 * stretch**2 / np.tan(muscle.braid_angle) ** 2 - 1 / np.sin(muscle.braid_angle) ** 2
    return np.asarray(pressure, dtype=float) * area * np.maximum(shape, 0.0)


def force_slope(pressure: Any, length: Any, arm: Arm) -> Array:
    """Return dF/dL [N/m] of `force` at constant pressure: the stiffness of a muscle at constant pressure."""
    muscle, rest = arm.muscle, arm.muscle_rest_length
    stretch = np.asarray(length, dtype=float) / rest
    area = np.pi * muscle.diameter**2 / 4
    slope = np.asarray(pressure, dtype=float) * area * 6 * stretch / (np.tan(muscle.braid_angle) ** 2 * rest)
    return np.where(force(1.0, length, arm) > 0, slope, 0.0)


def passive_tension(length: Any, arm: Arm) -> Array:
    """Return the tension [N] of the silicone alone: a spring beyond the rest length, slack below."""
    stretch = np.maximum(np.asarray(length, dtype=float) - arm.muscle_rest_length, 0.0)
    return (arm.muscle.passive_stiffness or 0.0) * stretch


def passive_slope(length: Any, arm: Arm) -> Array:
    """Return dF/dL [N/m] of `passive_tension`."""
    return np.where(np.asarray(length) > arm.muscle_rest_length, arm.muscle.passive_stiffness or 0.0, 0.0)


def pressure_for(tension: Any, length: Any, arm: Arm) -> Array:
    """Return the gauge pressure [Pa] at which a muscle of a length [m] has a tension [N], its silicone's included.

    0 where that alone pulls more; inf where no pressure does it.
    """
    per_pascal = force(1.0, length, arm)
    wanted = np.maximum(np.asarray(tension, dtype=float) - passive_tension(length, arm), 0.0)
    return np.divide(
        wanted, per_pascal, out=np.full(np.broadcast(wanted, per_pascal).shape, np.inf), where=per_pascal > 0
    )

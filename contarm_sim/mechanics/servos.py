"""Length servos: what controls give what tensions, and how much a moving muscle needs."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.model.arm import Arm

SERVO_SHARE = 0.2
"""Of the least tension, what a length servo keeps pulling with beside the damping along its muscle."""


def least_tensions(speeds: Array, min_tension: Array | float, arm: Arm) -> Array:
    """Return the least tensions [N], shape (..., n), of servo-driven muscles that lengthen at given speeds [m/s].

    Damping along a muscle pulls while it lengthens; the servo, which cannot push, keeps a share of the least tension.
    """
    damping = muscles.each(arm, lambda group: group.servo_stiffness * group.servo_time)
    return np.maximum(min_tension, damping * speeds + SERVO_SHARE * np.asarray(min_tension))


def servo_control(lengths: Array, tensions: Array, arm: Arm) -> Array:
    """Return controls of length servos, length changes [m], at which muscles of these lengths [m] have tensions [N]."""
    return np.asarray(muscles.by_group(lambda group, *given: group.setpoint(*given), arm, lengths, tensions))


def servo_tensions(control: Array, lengths: Array, arm: Arm) -> Array:
    """Return the tensions [N] of muscles of these lengths [m] under controls of length servos, see `servo_control`."""
    return np.asarray(muscles.by_group(lambda group, *given: group.servo_tension(*given), arm, control, lengths))

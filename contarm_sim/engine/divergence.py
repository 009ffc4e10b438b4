"""Bad states that the engine met: it resets the arm and carries on as if nothing had happened."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.errors import DivergenceError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

FATAL = [
    int(warning)
    for warning in (
        mujoco.mjtWarning.mjWARN_BADQPOS,
        mujoco.mjtWarning.mjWARN_BADQVEL,
        mujoco.mjtWarning.mjWARN_BADQACC,
    )
]
"""Warnings after which the engine has reset the arm."""


def divergence(
    model: mujoco.MjModel, numbers: Array, last: Array, time: float, settings: dict[str, Any]
) -> DivergenceError:
    """Return the error that tells of a bad state.

    Args:
        model: of the arm.
        numbers, last: how often the engine gave each warning, and what it was last about, shape (warnings,).
        time: when [s]; the engine's own clock is reset with the arm.
        settings: time step, integrator and gains, for the message.
    """
    fatal = next(i for i in FATAL if numbers[i])
    dof = int(last[fatal])
    name = model.joint(model.dof_jntid[dof]).name if 0 <= dof < model.nv else "?"
    return DivergenceError(time, dof, name, settings)


def stepping_settings(model: mujoco.MjModel, arm: Arm) -> dict[str, Any]:
    """Return what of the stepping belongs into the error."""
    return {
        "timestep": model.opt.timestep,
        "integrator": mujoco.mjtIntegrator(model.opt.integrator).name,
        "servo_stiffness": max((group.servo_stiffness for group in arm.groups), default=0.0),
    }


def any_fatal(numbers: Array) -> bool:
    """Whether any of the warnings, shape (..., warnings), are fatal."""
    return bool(np.asarray(numbers)[..., FATAL[0] : FATAL[-1] + 1].any())

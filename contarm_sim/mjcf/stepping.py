"""The time step of an arm among what it can touch, and what damping needs under Euler's integrator.

`implicitfast` steps by (M + step D) dv = step (f + contact), with damping D, but its contact solver sees M alone: links
are so light and so damped (step D is up to 500 M) that their contact buzzes. With step D as armature, plain Euler steps
by the very same equation, and contact sees all of it.

Under Euler the engine itself treats damping of joints so, where `eulerdamp` is on, as it is in most hosts. Damping of
tendons it never does: along the muscles it is explicit, and would make the arm diverge.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.mjcf import names
from contarm_sim.model.arm import Arm


def damp(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Give an arm in a spec, under its plain names, the armature that its damping is at the spec's time step."""
    if spec.option.integrator != mujoco.mjtIntegrator.mjINT_EULER:
        return
    parts = [tendon for name in names.muscles(arm) if (tendon := spec.tendon(name)) is not None]
    if _joints_too(spec.option):
        parts += [spec.joint(each.name) for each in names.joints(arm)]
    for part in parts:
        part.armature = spec.option.timestep * part.damping[0]


def set_step(model: mujoco.MjModel, step: float, dofs: slice, tendons: np.ndarray) -> None:
    """Set the time step [s] of a compiled model, and do in it what `damp` does in a spec.

    Args:
        dofs, tendons: the arm's.
    """
    model.opt.timestep = step
    implicit = step if model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER else 0.0
    model.tendon_armature[tendons] = implicit * model.tendon_damping[tendons]
    if _joints_too(model.opt):
        model.dof_armature[dofs] = implicit * model.dof_damping[dofs]


def _joints_too(option: Any) -> bool:
    return bool(option.disableflags & mujoco.mjtDisableBit.mjDSBL_EULERDAMP)

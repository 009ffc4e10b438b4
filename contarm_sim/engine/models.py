"""Compiled models, kept by what takes a compiler to change; an arm's other parameters are written into a copy.

Building and compiling takes several milliseconds, more than a static pose. What is written comes to the very bits that
compiling gives.
"""

from __future__ import annotations

import copy
from collections import OrderedDict
from dataclasses import dataclass, fields, replace
from threading import Lock
from typing import Any

import mujoco
import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import TIMESTEP, Actuation, arm_spec
from contarm_sim.mjcf.backbone import twist_stiffness
from contarm_sim.mjcf.muscles import servo_parameters
from contarm_sim.mjcf.routing import coefficient
from contarm_sim.model.arm import Arm

KEPT = 16
"""Most models kept."""

_WRITTEN = {"gravity", "base_orientation", "bending_stiffness", "torsional_stiffness", "damping_time"}
_KEY = [item.name for item in fields(Arm) if item.name not in _WRITTEN]


@dataclass(frozen=True)
class Built:
    """A model of one's own, and what its joints are.

    Attributes:
        model: the engine's.
        bending: indices of the hinges about x and y, by axis.
        twisting: indices of the hinges about z.
        by_angle: what parallel muscles gain in length by joint angles [m/rad], shape (3, dofs).
    """

    model: mujoco.MjModel
    bending: dict[str, Any]
    twisting: Any
    by_angle: Array

    def write(self, arm: Arm, actuation: Actuation) -> None:
        """Write an arm's parameters that are not in its `structure`, which must be this model's."""
        model = self.model
        model.opt.gravity[:] = arm.gravity
        k = arm.bending_stiffness / arm.link_pitch
        model.jnt_stiffness[:] = k
        model.dof_damping[:] = arm.damping_time * k
        if arm.torsional_stiffness is not None:
            model.jnt_stiffness[self.twisting] = twist_stiffness(arm, 3 * arm.muscle.min_tension)
            model.dof_damping[self.twisting] = arm.damping_time * arm.torsional_stiffness / arm.link_pitch
        if actuation == "lengths":
            kp, bias, control_range, damping = servo_parameters(arm)
            model.actuator_gainprm[:, 0] = kp
            model.actuator_biasprm[:, :3] = bias
            model.actuator_ctrlrange[:] = control_range
            model.tendon_damping[:] = damping


_kept: OrderedDict[Any, Built] = OrderedDict()
_lock = Lock()


def built(arm: Arm, actuation: Actuation) -> Built:
    """Return the model of `arm_spec` with the step `TIMESTEP`, bit for bit, as a copy that the caller may change.

    Raises:
        InputError: an unknown actuation.
    """
    key = structure(arm, actuation)
    with _lock:
        found = _kept.pop(key, None) or _compiled(arm, actuation)
        _kept[key] = found
        if len(_kept) > KEPT:
            _kept.popitem(last=False)
        model = copy.copy(found.model)
    own = replace(found, model=model)
    own.write(arm, actuation)
    return own


def structure(arm: Arm, actuation: Actuation) -> tuple[Any, ...]:
    """Return what a model is kept by."""
    return (actuation, arm.torsional_stiffness is None, *[getattr(arm, name) for name in _KEY])


def _compiled(arm: Arm, actuation: Actuation) -> Built:
    model = arm_spec(arm, actuation, TIMESTEP).compile()
    joints = [model.joint(i).name for i in range(model.njnt)]
    bending = {axis: np.flatnonzero([name.endswith(axis) for name in joints]) for axis in "xy"}
    twisting = np.flatnonzero([name.endswith("z") for name in joints])
    by_angle = np.array([[coefficient(arm, i, name) for name in joints] for i in range(3)])
    by_angle.setflags(write=False)
    return Built(model, bending, twisting, by_angle)

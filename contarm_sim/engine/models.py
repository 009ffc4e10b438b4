"""Compiled models, kept by what takes a compiler to change; an arm's other parameters are written into a copy.

Building and compiling takes several milliseconds, more than a static pose. What is written comes to the very bits that
compiling gives.
"""

from __future__ import annotations

import copy
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from threading import Lock
from typing import Any

import mujoco

from contarm_sim.engine.index import ArmIndex
from contarm_sim.mjcf import TIMESTEP, Actuation, arm_spec
from contarm_sim.mjcf.backbone import twist_stiffness
from contarm_sim.mjcf.muscles import ACTUATORS
from contarm_sim.model.arm import Arm

KEPT = 16
"""Most models kept."""

_WRITTEN = ("bending_stiffness", "torsional_stiffness", "damping_time")
"""Parameters of sections that are written; of the world, gravity and base are."""


@dataclass(frozen=True)
class Built:
    """A model of one's own, and where its parts are."""

    model: mujoco.MjModel
    index: ArmIndex

    def write(self, arm: Arm, actuation: Actuation) -> None:
        """Write an arm's parameters that are not in its `structure`, which must be this model's."""
        model, index = self.model, self.index
        model.opt.gravity[:] = arm.gravity
        for number, section in enumerate(arm.sections):
            own = index.section_of_joint == number
            model.jnt_stiffness[own] = section.joint_stiffness
            model.dof_damping[own] = section.damping_time * section.joint_stiffness
            if section.torsional_stiffness is not None:
                twisting = index.twisting[own[index.twisting]]
                model.jnt_stiffness[twisting] = twist_stiffness(arm, number)
                model.dof_damping[twisting] = section.damping_time * section.torsional_stiffness / section.link_pitch
        if actuation != "none":
            for group, muscles in zip(arm.groups, index.groups, strict=True):
                actuators = index.actuators[:, muscles].ravel()
                ACTUATORS[actuation].write(model, index.tendons[muscles], actuators, group)


Spec = Callable[[Arm, Actuation, float], mujoco.MjSpec]
"""What makes an arm's model: `arm_spec`, or the same arm with other sensors or nothing to look at."""

_kept: OrderedDict[Any, Built] = OrderedDict()
_lock = Lock()


def built(arm: Arm, actuation: Actuation, spec: Spec = arm_spec) -> Built:
    """Return the model of a spec with the step `TIMESTEP`, bit for bit, as a copy that the caller may change.

    Raises:
        InputError: an unknown actuation.
    """
    key = spec, structure(arm, actuation)
    with _lock:
        found = _kept.pop(key, None) or _compiled(arm, actuation, spec)
        _kept[key] = found
        if len(_kept) > KEPT:
            _kept.popitem(last=False)
        model = copy.copy(found.model)
    own = replace(found, model=model)
    own.write(arm, actuation)
    return own


def structure(arm: Arm, actuation: Actuation) -> tuple[Any, ...]:
    """Return what a model is kept by."""
    shapes = (
        tuple(None if name in _WRITTEN else value for name, value in vars(section).items()) for section in arm.sections
    )
    twists = tuple(section.torsional_stiffness is None for section in arm.sections)
    return actuation, twists, *shapes, arm.routings, arm.laws, arm.payload


def _compiled(arm: Arm, actuation: Actuation, spec: Spec) -> Built:
    model = spec(arm, actuation, TIMESTEP).compile()
    return Built(model, ArmIndex.of(model, arm))

"""Compiled models, kept by what takes a compiler to change; an arm's other parameters are written into a copy.

Building and compiling takes several milliseconds, more than a static pose. What is written comes to the very bits that
compiling gives.
"""

from __future__ import annotations

import copy
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from threading import Lock
from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.index import ArmIndex
from contarm_sim.errors import InputError
from contarm_sim.mjcf import TIMESTEP, Actuation, arm_spec
from contarm_sim.mjcf.backbone import inertia, links, payload_radius, twist_stiffness
from contarm_sim.mjcf.contact import leave_out_what_is_drawn
from contarm_sim.mjcf.muscles import ACTUATORS
from contarm_sim.mjcf.stepping import set_step
from contarm_sim.model.arm import Arm
from contarm_sim.model.host import Host
from contarm_sim.model.host_file import quiet

KEPT = 16
"""Most models kept."""

_WRITTEN = ("bending_stiffness", "torsional_stiffness", "damping_time", "friction_moment", "friction_stiffness")
"""Parameters of sections that are written, or that the engine knows nothing of: friction in the backbone.

Of the world, gravity, base and an unequal payload are written.

So is the mass of one section. That of several moves the middle of the links between them: there it is compiled.
"""


@dataclass(frozen=True)
class Built:
    """A model of one's own, and where its parts are."""

    model: mujoco.MjModel
    index: ArmIndex

    @property
    def hosted(self) -> bool:
        """Whether the arm is in a host, whose options stay as they are."""
        return bool(self.index.base_pose.size)

    @property
    def in_world(self) -> bool:
        """Whether more than the arm is in the model: a host, or what it can touch."""
        return self.hosted or not self.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT

    def step_by(self, timestep: float) -> None:
        """Set the engine's step [s], and what goes with it."""
        self.model.opt.timestep = timestep
        if self.in_world:
            set_step(self.model, timestep, self.index.dofs, self.index.tendons)

    def unlimit(self) -> None:
        """Let the arm's servos push, and be set to any length."""
        own = self.index.actuators.ravel()
        self.model.actuator_forcelimited[own] = self.model.actuator_ctrllimited[own] = 0

    def write(self, arm: Arm, actuation: Actuation) -> None:
        """Write an arm's parameters that are not in its `structure`, which must be this model's, of the arm alone.

        Raises:
            ValueError: there is more than the arm in the model.
        """
        if self.in_world:
            raise ValueError("parameters are written into models of an arm alone; among objects, compile it anew")
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
        self._weigh(arm)
        if actuation != "none":
            for group, muscles in zip(arm.groups, index.groups, strict=True):
                actuators = index.actuators[:, muscles].ravel()
                ACTUATORS[actuation].write(model, index.tendons[muscles], actuators, group)

    @cached_property
    def _data(self) -> mujoco.MjData:
        """What the engine derives constants in."""
        return mujoco.MjData(self.model)

    def _weigh(self, arm: Arm) -> None:
        """Write masses and inertias, and what the engine derives of them, where they are others."""
        model, index = self.model, self.index
        alone = arm.sections[0] if len(arm.sections) == 1 else None
        same = alone is None or 0.5 * alone.mass / alone.links == model.body_mass[index.base]
        if same and arm.payload == model.body_mass[index.payload]:
            return
        if not same:
            mass, _, across, along = np.array([inertia(link) for link in links(arm)]).T
            model.body_mass[index.stations] = mass
            model.body_inertia[index.stations] = np.stack([across, across, along], axis=-1)
        model.body_mass[index.payload] = arm.payload
        mujoco.mj_setConst(model, self._data)
        model.stat.meaninertia = sum(model.dof_M0.tolist()) / model.nv  # one after the other, as the engine adds
        model.stat.meanmass = sum(model.body_mass[1:].tolist()) / (model.nbody - 1)
        ball = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, "payload")
        if ball >= 0:
            radius = payload_radius(arm)
            model.geom_size[ball, 0] = model.geom_rbound[ball] = model.geom_aabb[ball, 3:] = radius


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


def built_in_world(arm: Arm, actuation: Actuation) -> Built:
    """Return the model of an arm with all that it can touch, compiled anew; of an arm alone where that is nothing.

    Raises:
        InputError: an unknown actuation, objects that the engine cannot make, or a host that changes the arm.
    """
    if not arm.world.touchable:
        return built(arm, actuation)
    spec = arm_spec(arm.without_memory, actuation, TIMESTEP)
    leave_out_what_is_drawn(spec, arm)
    with quiet():
        model = spec.compile()
    found = Built(model, ArmIndex.of(model, arm, in_world=True))
    if arm.world.host is not None:
        _check_unchanged(found, built(arm, actuation), arm.world.host)
    return found


def _check_unchanged(found: Built, alone: Built, host: Host) -> None:
    """Refuse a host whose compiler gives the arm's links other masses, or inertias.

    Raises:
        InputError: says so.
    """
    for name in ("body_mass", "body_inertia"):
        own, usual = (getattr(each.model, name)[each.index.bodies] for each in (found, alone))
        if not np.allclose(own, usual, rtol=1e-9, atol=0):
            given = f"{Path(host.file).name!r}, whose <compiler> changes the masses of the arm"
            allowed = "no settotalmass, boundmass, boundinertia, balanceinertia or inertiafromgeom"
            raise InputError("world", given, allowed)


def structure(arm: Arm, actuation: Actuation) -> tuple[Any, ...]:
    """Return what a model is kept by."""
    written = (*_WRITTEN, "mass") if len(arm.sections) == 1 else _WRITTEN
    shapes = (
        tuple(None if name in written else value for name, value in vars(section).items()) for section in arm.sections
    )
    twists = tuple(section.torsional_stiffness is None for section in arm.sections)
    return actuation, twists, *shapes, arm.routings, arm.laws, arm.payload > 0


def _compiled(arm: Arm, actuation: Actuation, spec: Spec) -> Built:
    model = spec(arm.alone.without_memory, actuation, TIMESTEP).compile()
    return Built(model, ArmIndex.of(model, arm))

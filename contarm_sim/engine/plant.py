"""The engine behind named quantities: model and data of one simulated arm."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.index import ArmIndex, rows
from contarm_sim.engine.models import built
from contarm_sim.engine.room import engine_room as engine_room
from contarm_sim.engine.room import quiet_engine as quiet_engine
from contarm_sim.engine.twist import TwistedMuscles
from contarm_sim.errors import DivergenceError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import force_slope, passive_slope, passive_tension
from contarm_sim.mechanics.routing import section_angles
from contarm_sim.mjcf import TIMESTEP, Actuation
from contarm_sim.mjcf.names import section_stations
from contarm_sim.mjcf.stability import tendon_jacobian
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


class Plant:
    """A simulated arm. The base frame is the engine's world frame; gravity is the arm's.

    Args:
        arm: its parameters.
        pull_only: limit muscle forces to pulling, at most the blocked force. False gives plain
            position servos, which also push: what the paper's lengths meet when read naively.
        timestep: engine step [s]; default 5 ms, which suits most arms.
        integrator: engine integrator; default the model's.
        actuation: `lengths` (servos), `pressures` (McKibben muscles behind valves), `tensions` (plain forces) or `none`
            (a bare backbone).

    Attributes:
        model, data: the engine's.
        index: where the arm's parts are in them.
        centres: what `stations` copies, as a view into the engine's memory that stays current.
        control: the engine's controls as a view, one column a muscle: assign length changes [m], pressures [Pa] or
            tensions [N], shape (M,) of M muscles, to all of it.
        pressure: pressures behind the valves [Pa], a view like `control`; empty for servos.
        actuation: what drives the muscles.
        constant_tensions: whether controls are tensions.
        damping: of each muscle along itself [N s/m], shape (M,).
        springs: stiffness of the joints without what `twisted` adds [N m/rad], shape (dofs,).
        twisted: what twist does to parallel muscles driven by tensions or pressures; None where nothing twists them,
            and under length servos, see `stiffen_twist`.
    """

    def __init__(
        self,
        arm: Arm,
        pull_only: bool = True,
        timestep: float | None = None,
        integrator: mujoco.mjtIntegrator | None = None,
        actuation: Actuation = "lengths",
    ) -> None:
        self.actuation, self.constant_tensions = actuation, actuation == "tensions"
        self._own = own = built(arm, actuation)
        self.model, self.index = own.model, own.index
        self.model.opt.timestep = timestep or TIMESTEP
        if not pull_only:
            self.model.actuator_forcelimited[:] = 0
            self.model.actuator_ctrllimited[:] = 0
        if integrator is not None:
            self.model.opt.integrator = integrator
        self.data = mujoco.MjData(self.model)
        # Views into the engine's memory: they stay current, and cost nothing to look up in a loop.
        self.centres = self.data.xpos[self.index.stations]
        self.control = self.data.ctrl[_all(self.index)].reshape(self.index.actuators.shape)
        self.pressure = self.data.act.reshape(-1 if self.model.na else 0, self.index.actuators.shape[1])
        self._force = self.data.actuator_force[_all(self.index)].reshape(self.index.actuators.shape)
        self._warnings = self.data.warning.number
        self.warned = memoryview(self._warnings)
        self._straight_lengths = np.array([group.length for group in arm.groups for _ in range(group.routing.count)])
        self._zero, self._by_angle, self._twisting = self.index.zero, self.index.by_angle, self.index.twisting
        self._parallel = not self.index.straight.any()
        self._follow(arm)

    def _follow(self, arm: Arm) -> None:
        self.arm = arm
        self.damping = self.model.tendon_damping.copy() if self.model.ntendon else np.zeros(len(self._zero))
        self.springs, self.twisted, self._helices = self.model.jnt_stiffness.copy(), None, None
        if self._twisting.size:
            self._untwisting = np.array([
                (section.torsional_stiffness or 0.0) / section.link_pitch
                for section in (arm.sections[number] for number in self.index.section_of_joint[self._twisting])
            ])  # fmt: skip
            self.springs[self._twisting] = self._untwisting
            if not self.index.straight.all() and self.model.nu:
                self._helices = TwistedMuscles(arm, self.index, self.data.qpos)
                self.twisted = None if self.actuation == "lengths" else self._helices

    @property
    def muscle_lengths(self) -> Array:
        """Muscle lengths [m], shape (M,), as the engine measures them, and what twist adds to parallel muscles."""
        if not self.model.ntendon:
            return self._straight_lengths + self._by_angle @ self.data.qpos
        lengths = self.data.ten_length + self._zero
        return lengths if self.twisted is None else lengths + self.twisted.stretch().sum(axis=1)

    @property
    def muscle_jacobian(self) -> Array:
        """What muscle lengths gain by joint angles [m/rad], shape (M, dofs)."""
        if self.twisted is not None and self._parallel:
            return self.twisted.jacobian()
        if self._parallel or not self.model.ntendon:  # straight spans that nothing pulls have no part in it
            return self._by_angle
        J = tendon_jacobian(self.model, self.data)
        if self.twisted is not None:
            J[~self.index.straight] = self.twisted.jacobian()[~self.index.straight]
        return J

    @property
    def muscle_tensions(self) -> Array:
        """Muscle tensions [N], pulling > 0, shape (M,): `muscle_forces` and what stretched silicone pulls with."""
        if not self.model.ntendon:
            return np.zeros(len(self._zero))
        engine = self.data.ten_length + self._zero
        tensions = self.muscle_forces + passive_tension(engine, self.arm)
        if self.twisted is not None:
            tensions = tensions + self.muscle_slopes * self.twisted.stretch().sum(axis=1)
        return tensions

    @property
    def muscle_forces(self) -> Array:
        """What actuators and damping along the muscles pull with [N], pulling > 0, shape (M,).

        Actuators do not push; damping does where a slack muscle shortens.
        """
        return self.damping * self.data.ten_velocity - self._force.sum(axis=0)

    @property
    def servo_pulls(self) -> Array:
        """What the actuators alone pull with [N], pulling > 0, shape (3,)."""
        return np.asarray(-self.data.actuator_force.reshape(-1, self.control.shape[1]).sum(axis=0))

    @property
    def muscle_slopes(self) -> Array:
        """What tensions gain by length [N/m], shape (M,), controls and pressures as they are."""
        model, data = self.model, self.data
        if not model.ntendon:
            return np.zeros(len(self._zero))
        lengths = self.muscle_lengths
        silicone = passive_slope(lengths, self.arm)
        if len(self.pressure):
            return force_slope(self.pressure[0], lengths, self.arm) + silicone
        low, high = model.actuator_forcerange.T
        at_limit = (model.actuator_forcelimited != 0) & ((data.actuator_force <= low) | (data.actuator_force >= high))
        return np.where(at_limit, 0.0, -model.actuator_biasprm[:, 1]) + silicone

    def stiffen_twist(self) -> None:
        """Let twisted parallel muscles stiffen the engine's joints by their present tensions, as fixed tendons do not.

        In motion that is all that twist does to them, and at rest under length servos, which measure what the engine
        does. Under tensions and pressures statics also have what a muscle's longer way does to tension and to bending:
        0.1 to 0.3 % of length at the tip of an arm twisted by 30 deg, more where tensions are high.
        """
        if self._helices is not None:
            added = self._helices.joint_stiffness(self.muscle_tensions)
            self.model.jnt_stiffness[self._twisting] = self._untwisting + added

    def tighten(self, tensions: Array) -> None:
        """Let tensions [N], shape (M,), stiffen the twisting joints' `springs`, where no `twisted` does it all."""
        if self._helices is not None and self.twisted is None:
            self.springs[self._twisting] = self._untwisting + self._helices.joint_stiffness(tensions)

    @property
    def twist_by_tension(self) -> Array | float:
        """What a newton of each muscle adds to the moment against twist by `tighten` [m], shape (M, dofs), or 0."""
        if self._helices is None or self.twisted is not None:
            return 0.0
        return self._helices.against_twist()

    @property
    def turning(self) -> bool:
        """Whether `stiffen_twist` does anything."""
        return self._helices is not None

    @property
    def stations(self) -> Array:
        """Centres of base plate, disks and tip plate [m], shape (links + 1, 3)."""
        return self.centres.copy()

    @property
    def tip(self) -> Array:
        """Tip position [m], shape (3,)."""
        return self.centres[-1].copy()

    @property
    def tip_rotation(self) -> Array:
        """Orientation of the tip, shape (3, 3)."""
        return self.rotations[-1]

    @property
    def rotations(self) -> Array:
        """Orientations of base plate, links and tip, shape (links + 1, 3, 3)."""
        return self.data.xmat[self.index.stations].reshape(-1, 3, 3).copy()

    @property
    def muscle_paths(self) -> Array:
        """Points that muscles run through, one a station [m], shape (M, links + 1, 3); NaN where a muscle is not."""
        local = np.array([[*point, 0.0] for group in self.arm.groups for point in group.routing.points])
        points = self.centres + np.einsum("sij,mj->msi", self.rotations, local.reshape(-1, 3))
        axes, starts = self.rotations[:, :, 2], section_stations(self.arm)
        for group, muscles in zip(self.arm.groups, self.index.groups, strict=True):
            first, last = starts[group.first], starts[group.section + 1]
            if group.routing.path == "spans":
                for number in range(group.first, group.section + 1):
                    own = slice(starts[number], starts[number + 1])
                    points[muscles, own] += self.arm.sections[number].guide_height * axes[own]
            points[muscles, :first] = points[muscles, last + 1 :] = np.nan
        return points

    def become(self, arm: Arm) -> None:
        """Take an arm's parameters, which must be of the same structure, see `models`; reset afterwards."""
        self._own.write(arm, self.actuation)
        self._follow(arm)

    def reset(self, bend: Array | None = None) -> None:
        """Put the arm at rest with all joints of a section bent alike, the first guess of a pose.

        Args:
            bend: of each section [rad], shape (sections, 2), or (2,) for all alike; default straight.
        """
        mujoco.mj_resetDataKeyframe(self.model, self.data, 0)
        bends = np.broadcast_to(np.zeros(2) if bend is None else bend, (len(self.arm.sections), 2))
        for number, (section, routing) in enumerate(zip(self.arm.sections, self.arm.routings, strict=True)):
            share = section_angles(bends[number], section, routing)[0] / section.links
            for axis, angle in (("x", -share[1]), ("y", share[0])):
                hinges = self.index.bending[axis]
                self.data.qpos[hinges[self.index.section_of_joint[hinges] == number]] = angle

    def restart(self, qpos: Array, control: Array) -> None:
        """Put the arm at rest with joint angles [rad], shape (dofs,), controls, shape (M,), sent and reached."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = qpos
        self.control[:] = control
        if len(self.pressure):
            self.pressure[:] = control
        mujoco.mj_forward(self.model, self.data)

    def pose(self) -> None:
        """Derive what forces at rest need of the present joint angles: frames, muscle lengths, actuator forces."""
        model, data = self.model, self.data
        data.qvel[:] = 0
        data.ten_velocity[:] = 0
        data.actuator_velocity[:] = 0
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        mujoco.mj_transmission(model, data)
        mujoco.mj_fwdActuation(model, data)

    def tip_jacobian(self) -> Array:
        """Return the tip's velocity and rotation [m/s, rad/s] by joint rates, shape (6, dofs)."""
        J = np.zeros((6, self.model.nv))
        mujoco.mj_jacBody(self.model, self.data, J[:3], J[3:], self.model.body("tip").id)
        return J

    def inertial_forces(self, q: Array, v: Array, a: Array) -> Array:
        """Return the forces of inertia and joint damping [N m], shape (dofs,), of a motion: angles, rates, and theirs.

        The plant is left at the angles, at rest.
        """
        model, data = self.model, self.data
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        inertia, coriolis = np.zeros(model.nv), data.qfrc_bias.copy()
        mujoco.mj_mulM(model, data, inertia, data.qacc)
        data.qvel[:] = 0
        mujoco.mj_fwdVelocity(model, data)
        return np.asarray(inertia + coriolis - data.qfrc_bias + model.dof_damping * v)

    def check(self, settings: dict[str, Any]) -> None:
        """Raise if the engine met a bad state: it would reset the arm and carry on as if nothing had happened.

        Raises:
            DivergenceError: with the time, the degree of freedom and the settings.
        """
        if any(self._warnings.tolist()) and self._warnings[FATAL].any():
            fatal = next(self.data.warning[i] for i in FATAL if self.data.warning[i].number)
            dof = int(fatal.lastinfo)
            name = self.model.joint(self.model.dof_jntid[dof]).name if 0 <= dof < self.model.nv else "?"
            raise DivergenceError(float(self.data.time), dof, name, settings)


def _all(index: ArmIndex) -> slice:
    """Return the rows of all actuators, which follow one another round by round."""
    return rows(index.actuators.ravel()) if index.actuators.size else slice(0, 0)

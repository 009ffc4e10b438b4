"""The engine behind named quantities: model and data of one simulated arm."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.models import built
from contarm_sim.engine.room import engine_room as engine_room
from contarm_sim.engine.room import quiet_engine as quiet_engine
from contarm_sim.engine.twist import TwistedMuscles
from contarm_sim.errors import DivergenceError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import force_slope, passive_slope, passive_tension
from contarm_sim.mechanics.routing import joint_angles
from contarm_sim.mjcf import TIMESTEP, Actuation
from contarm_sim.mjcf.routing import angle, counted_from
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
        centres: what `stations` copies, as a view into the engine's memory that stays current.
        control: the engine's controls as a view, one column a muscle: assign length changes [m], pressures [Pa] or
            tensions [N], shape (3,), to all of it.
        pressure: pressures behind the valves [Pa], a view like `control`; empty for servos.
        actuation: what drives the muscles.
        constant_tensions: whether controls are tensions.
        damping: of each muscle along itself [N s/m], shape (3,).
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
        self.model = own.model
        self.model.opt.timestep = timestep or TIMESTEP
        if not pull_only:
            self.model.actuator_forcelimited[:] = 0
            self.model.actuator_ctrllimited[:] = 0
        if integrator is not None:
            self.model.opt.integrator = integrator
        self.data = mujoco.MjData(self.model)
        # Views into the engine's memory: they stay current, and cost nothing to look up in a loop.
        self.centres = self.data.xpos[self.model.body("base").id : self.model.body("tip").id + 1]
        self.control = self.data.ctrl.reshape(self.model.nu // 3, 3)
        self.pressure = self.data.act.reshape(self.model.na // 3, 3)
        self._warnings = self.data.warning.number
        self.warned = memoryview(self._warnings)
        self._bending, self._twisting, self._by_angle = own.bending, own.twisting, own.by_angle
        self._zero = counted_from(arm)
        self._follow(arm)

    def _follow(self, arm: Arm) -> None:
        self.arm = arm
        self.damping = self.model.tendon_damping.copy() if self.model.ntendon else np.zeros(3)
        self.springs, self.twisted, self._helices = self.model.jnt_stiffness.copy(), None, None
        if arm.torsional_stiffness is not None:
            self._untwisting = arm.torsional_stiffness / arm.link_pitch
            self.springs[self._twisting] = self._untwisting
            if arm.muscle.path == "parallel" and self.model.nu:
                self._helices = TwistedMuscles(arm, self._by_angle, self._twisting, self.data.qpos)
                self.twisted = None if self.actuation == "lengths" else self._helices

    @property
    def muscle_lengths(self) -> Array:
        """Muscle lengths [m], shape (3,), as the engine measures them, and what twist adds to parallel muscles."""
        if not self.model.ntendon:
            return self.arm.length + self._by_angle @ self.data.qpos
        lengths = self.data.ten_length + self._zero
        return lengths if self.twisted is None else lengths + self.twisted.stretch().sum(axis=1)

    @property
    def muscle_jacobian(self) -> Array:
        """What muscle lengths gain by joint angles [m/rad], shape (3, dofs)."""
        model, data = self.model, self.data
        if self.twisted is not None:
            return self.twisted.jacobian()
        if self.arm.muscle.path == "parallel":
            return self._by_angle
        J = np.zeros((3, model.nv))
        mujoco.mju_sparse2dense(J, data.ten_J, model.ten_J_rownnz, model.ten_J_rowadr, model.ten_J_colind)
        return J

    @property
    def muscle_tensions(self) -> Array:
        """Muscle tensions [N], pulling > 0, shape (3,): `muscle_forces` and what stretched silicone pulls with."""
        if not self.model.ntendon:
            return np.zeros(3)
        engine = self.data.ten_length + self._zero
        tensions = self.muscle_forces + passive_tension(engine, self.arm)
        if self.twisted is not None:
            tensions = tensions + self.muscle_slopes * self.twisted.stretch().sum(axis=1)
        return tensions

    @property
    def muscle_forces(self) -> Array:
        """What actuators and damping along the muscles pull with [N], pulling > 0, shape (3,).

        Actuators do not push; damping does where a slack muscle shortens.
        """
        return self.damping * self.data.ten_velocity - self.data.actuator_force.reshape(-1, 3).sum(axis=0)

    @property
    def servo_pulls(self) -> Array:
        """What the actuators alone pull with [N], pulling > 0, shape (3,)."""
        return np.asarray(-self.data.actuator_force.reshape(-1, self.control.shape[1]).sum(axis=0))

    @property
    def muscle_slopes(self) -> Array:
        """What tensions gain by length [N/m], shape (3,), controls and pressures as they are."""
        model, data = self.model, self.data
        if not model.ntendon:
            return np.zeros(3)
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
        """Let tensions [N], shape (3,), stiffen the twisting joints' `springs`, where no `twisted` does it all."""
        if self._helices is not None and self.twisted is None:
            self.springs[self._twisting] = self._untwisting + self._helices.joint_stiffness(tensions)

    @property
    def twist_by_tension(self) -> Array | float:
        """What a newton of each muscle adds to the moment against twist by `tighten` [m], shape (3, dofs), or 0."""
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
        first = self.model.body("base").id
        return self.data.xmat[first : first + self.arm.links + 1].reshape(-1, 3, 3).copy()

    @property
    def muscle_paths(self) -> Array:
        """Points that the muscles run through, one a station [m], shape (3, links + 1, 3)."""
        angles = [angle(i) for i in range(3)]
        arm, spans = self.arm, self.arm.muscle.path == "spans"
        local = np.array([[arm.muscle_radius * np.cos(a), arm.muscle_radius * np.sin(a), 0.0] for a in angles])
        points = self.centres + np.einsum("sij,mj->msi", self.rotations, local)
        if spans:
            points[:, :-1] += arm.guide_height * self.rotations[:-1, :, 2]
        return points

    def become(self, arm: Arm) -> None:
        """Take an arm's parameters, which must be of the same structure, see `models`; reset afterwards."""
        self._own.write(arm, self.actuation)
        self._follow(arm)

    def reset(self, bend: Array) -> None:
        """Put the arm at rest with every joint bent alike, the first guess of a pose at this bend [rad]."""
        mujoco.mj_resetDataKeyframe(self.model, self.data, 0)
        share = joint_angles(bend, self.arm)[0] / self.arm.links
        self.data.qpos[self._bending["x"]] = -share[1]
        self.data.qpos[self._bending["y"]] = share[0]

    def restart(self, qpos: Array, control: Array) -> None:
        """Put the arm at rest with joint angles [rad], shape (dofs,), controls, shape (3,), sent and reached."""
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

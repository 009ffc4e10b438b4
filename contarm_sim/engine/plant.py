"""The engine behind named quantities: model and data of one simulated arm."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.divergence import FATAL as FATAL
from contarm_sim.engine.divergence import any_fatal, divergence
from contarm_sim.engine.driven import DrivenMuscles
from contarm_sim.engine.index import ArmIndex, rows
from contarm_sim.engine.models import built, built_in_world
from contarm_sim.engine.room import engine_room as engine_room
from contarm_sim.engine.room import quiet_engine as quiet_engine
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.routing import section_angles
from contarm_sim.mjcf import TIMESTEP, Actuation
from contarm_sim.model.arm import Arm


class Plant(DrivenMuscles):
    """A simulated arm and its `DrivenMuscles`. The base frame is the engine's world frame, but in a host.

    Gravity is the arm's.

    Args:
        arm: its parameters.
        pull_only: limit muscle forces to pulling, at most the blocked force. False gives plain
            position servos, which also push: what the paper's lengths meet when read naively.
        timestep: engine step [s]; default 5 ms, which suits most arms, or a host's where that is less.
        integrator: engine integrator; default the model's.
        actuation: `lengths` (servos), `pressures` (pneumatic muscles behind valves), `tensions` (plain forces) or
            `none` (a bare backbone).
        in_world: with all that the arm can touch, in its host if it has one; otherwise the arm
            is alone.

    Attributes:
        model, data: the engine's.
        index: where the arm's parts are in them.
        own: the model and the index, in one.
        pull_only, integrator: as given.
        hosted: whether the arm is in a host: `centres` are then in its world, all else is in the base frame.
        tip_seen: the tip in the base frame [m], a view that stays current, shape (3,).
        centres: what `stations` copies, as a view into the engine's memory that stays current.
        gravity: the engine's [m/s^2], likewise.
    """

    def __init__(
        self,
        arm: Arm,
        pull_only: bool = True,
        timestep: float | None = None,
        integrator: mujoco.mjtIntegrator | None = None,
        actuation: Actuation = "lengths",
        in_world: bool = False,
    ) -> None:
        self.own = own = built_in_world(arm, actuation) if in_world else built(arm, actuation)
        self.model, self.index = own.model, own.index
        self.pull_only, self.integrator = pull_only, integrator
        self.hosted = own.hosted
        if not pull_only:
            own.unlimit()
        if integrator is not None:
            self.model.opt.integrator = integrator
        host = arm.world.host if in_world else None
        own.step_by(timestep or (TIMESTEP if host is None else min(TIMESTEP, host.read.timestep)))
        self.data = mujoco.MjData(self.model)
        # Views into the engine's memory: they stay current, and cost nothing to look up in a loop.
        self.centres, self.gravity = self.data.xpos[self.index.stations], self.model.opt.gravity
        self.tip_seen = self.data.sensordata[rows(self.index.tip_position)] if self.hosted else self.centres[-1]
        self.mass = self.model.body_mass[self.index.bodies]
        self._warnings = self.data.warning.number
        self.warned = memoryview(self._warnings)
        super().__init__(arm, self.model, self.data, self.index, actuation)

    @property
    def stations(self) -> Array:
        """Centres of base plate, disks and tip plate [m], shape (links + 1, 3)."""
        return self.to_base(self.centres) if self.hosted else self.centres.copy()

    @property
    def tip(self) -> Array:
        """Tip position [m], shape (3,)."""
        return self.tip_seen.copy()

    @property
    def tip_rotation(self) -> Array:
        """Orientation of the tip, shape (3, 3)."""
        return self.rotations[-1]

    @property
    def rotations(self) -> Array:
        """Orientations of base plate, links and tip, shape (links + 1, 3, 3)."""
        found = self.data.xmat[self.index.stations].reshape(-1, 3, 3)
        return self.data.xmat[self.index.base].reshape(3, 3).T @ found if self.hosted else found.copy()

    def to_base(self, points: Array) -> Array:
        """Return points of the engine's world [m], shape (..., 3), in the base frame."""
        base = self.data.xpos[self.index.base]
        return np.asarray((points - base) @ self.data.xmat[self.index.base].reshape(3, 3))

    def become(self, arm: Arm) -> None:
        """Take an arm's parameters, which must be of the same structure, see `models`; reset afterwards.

        Raises:
            ValueError: the plant is in its world.
        """
        self.own.write(arm, self.actuation)
        self._follow(arm)

    def reset(self, bend: Array | None = None) -> None:
        """Put the arm at rest with all joints of a section bent alike, the first guess of a pose.

        Args:
            bend: of each section [rad], shape (S, 2) or (2 S,), or (2,) for all alike; default straight.
        """
        mujoco.mj_resetDataKeyframe(self.model, self.data, 0)
        bent(self.qpos, self.arm, self.index, np.zeros(2) if bend is None else bend)

    def restart(self, qpos: Array, control: Array) -> None:
        """Put the arm at rest with joint angles [rad], shape (dofs,), controls, shape (M,), sent and reached."""
        if self.hosted:
            mujoco.mj_resetDataKeyframe(self.model, self.data, 0)
        else:
            mujoco.mj_resetData(self.model, self.data)
        self.qpos[:] = qpos
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
        mujoco.mj_jacBody(self.model, self.data, J[:3], J[3:], self.index.tip)
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

    def check(self, settings: dict[str, Any], time: float | None = None) -> None:
        """Raise if the engine met a bad state: it would reset the arm and carry on as if nothing had happened.

        Args:
            settings: for the message.
            time: when [s]; default what the engine's clock says, which starts again with the arm.

        Raises:
            DivergenceError: with the time, the degree of freedom and the settings.
        """
        if any(self._warnings.tolist()) and any_fatal(self._warnings):
            when = float(self.data.time) if time is None else time
            raise divergence(self.model, self._warnings, self.data.warning.lastinfo, when, settings)


def bent(qpos: Array, arm: Arm, index: ArmIndex, bend: Array) -> None:
    """Write bends of sections [rad] into joint angles [rad], shape (..., dofs), those of a section all alike.

    Args:
        bend: shape (S, 2) or (2 S,), or (2,) for all alike; of many, shape (..., S, 2).
    """
    given = np.asarray(bend)
    bends = np.broadcast_to(given.reshape(-1, 2), (len(arm.sections), 2)) if qpos.ndim == 1 else given
    for number, (section, routing) in enumerate(zip(arm.sections, arm.routings, strict=True)):
        share = section_angles(bends[..., number, :], section, routing)[0] / section.links
        for axis, angle in (("x", -share[..., 1]), ("y", share[..., 0])):
            hinges = index.bending[axis]
            qpos[..., hinges[index.section_of_joint[hinges] == number]] = angle[..., None]

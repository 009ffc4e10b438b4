"""The engine behind named quantities: model and data of one simulated arm."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np
from threadpoolctl import threadpool_limits

from contarm_sim.arm import Arm
from contarm_sim.errors import DivergenceError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import force_slope, passive_slope, passive_tension
from contarm_sim.mechanics.routing import joint_angles
from contarm_sim.mjcf import TIMESTEP, Actuation, arm_spec
from contarm_sim.mjcf.routing import angle, coefficient, counted_from
from contarm_sim.simulation.twist import TwistedMuscles

FATAL = [
    int(warning)
    for warning in (
        mujoco.mjtWarning.mjWARN_BADQPOS,
        mujoco.mjtWarning.mjWARN_BADQVEL,
        mujoco.mjtWarning.mjWARN_BADQACC,
    )
]
"""Warnings after which the engine has reset the arm."""


@contextmanager
def engine_room() -> Iterator[None]:
    """Run simulations inside: no warnings written to MUJOCO_LOG.TXT, no BLAS threads.

    `Plant.check` reads the engine's warning counters instead. The matrices here are small: a second BLAS thread gains
    nothing, and spins beside the stepping loop until that takes twice as long.
    """
    with quiet_engine(), threadpool_limits(1, user_api="blas"):
        yield


@contextmanager
def quiet_engine() -> Iterator[None]:
    """Keep the engine from writing warnings to MUJOCO_LOG.TXT; its counters still tell."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_ignore)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)


def _ignore(message: str) -> None:
    pass


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
        twisted: what twist does to parallel muscles; None where nothing twists them.
    """

    def __init__(
        self,
        arm: Arm,
        pull_only: bool = True,
        timestep: float | None = None,
        integrator: mujoco.mjtIntegrator | None = None,
        actuation: Actuation = "lengths",
    ) -> None:
        self.arm, self.actuation, self.constant_tensions = arm, actuation, actuation == "tensions"
        self.model = arm_spec(arm, actuation, timestep or TIMESTEP).compile()
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
        self.damping = self.model.tendon_damping.copy() if self.model.ntendon else np.zeros(3)
        self._warnings = self.data.warning.number
        self.warned = memoryview(self._warnings)
        joints = [self.model.joint(i).name for i in range(self.model.njnt)]
        self._bending = {axis: np.flatnonzero([name.endswith(axis) for name in joints]) for axis in "xy"}
        self._twisting = np.flatnonzero([name.endswith("z") for name in joints])
        self._zero = counted_from(arm)
        self._by_angle = np.array([[coefficient(arm, i, name) for name in joints] for i in range(3)])
        turning = len(self._twisting) > 0 and arm.muscle.path == "parallel" and self.model.nu > 0
        twisted = TwistedMuscles(arm, self._by_angle, self._twisting, self.data.qpos)
        self.twisted = twisted if turning else None

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

    def stiffen_twist(self) -> Array | float:
        """Let twisted parallel muscles stiffen the arm by their present tensions, which fixed tendons do not do.

        In motion, stiffness against twist is all. The forces returned also have what a muscle's longer way does to its
        tension and to bending: 0.1 to 0.3 % of length at the tip of an arm twisted by 30 deg.

        Returns:
            what that changes in the generalised forces last derived [N m], shape (dofs,), or 0.
        """
        if self.twisted is None:
            return 0.0
        stiffness, twisting, tensions = self.model.jnt_stiffness, self._twisting, self.muscle_tensions
        wanted = self.twisted.joint_stiffness(tensions)
        change = self.twisted.bending_forces(tensions, self.muscle_slopes)
        change[twisting] = (stiffness[twisting] - wanted) * self.data.qpos[twisting]
        stiffness[twisting] = wanted
        return change

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

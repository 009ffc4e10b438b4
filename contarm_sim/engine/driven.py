"""The muscles of a simulated arm: how they are driven, and what is read of them."""

from __future__ import annotations

import mujoco
import numpy as np

from contarm_sim.engine.index import ArmIndex, rows
from contarm_sim.engine.twist import TwistedMuscles
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import force_slope, passive_slope, passive_tension
from contarm_sim.mjcf import Actuation
from contarm_sim.mjcf.names import section_stations
from contarm_sim.mjcf.stability import tendon_jacobian
from contarm_sim.model.arm import Arm


class DrivenMuscles:
    """The M muscles of an arm in a model that is its alone.

    Args:
        arm: its parameters.
        model, data: the engine's.
        index: where the arm's parts are in them.
        actuation: what drives the muscles.

    Attributes:
        qpos: joint angles [rad], a view, shape (dofs,).
        control: the engine's controls as a view, one column a muscle: assign length changes [m], pressures [Pa] or
            tensions [N], shape (M,) of M muscles, to all of it.
        pressure: pressures behind the valves [Pa], a view like `control`; empty for servos.
        actuation: what drives the muscles.
        constant_tensions: whether controls are tensions.
        straight_lengths: of the muscles in the straight arm [m], shape (M,).
        damping: of each muscle along itself [N s/m], shape (M,).
        springs: stiffness of the joints without what `twisted` adds [N m/rad], shape (dofs,).
        untwisting: what joints resist twist with of themselves [N m/rad], one number for each that twists.
        helices: the muscles as twist finds them; None where nothing twists them.
        twisted: what twist does to parallel muscles driven by tensions or pressures; None where nothing twists them,
            and under length servos, see `stiffen_twist`.
    """

    def __init__(
        self, arm: Arm, model: mujoco.MjModel, data: mujoco.MjData, index: ArmIndex, actuation: Actuation
    ) -> None:
        self.actuation, self.constant_tensions = actuation, actuation == "tensions"
        self.model, self.data, self.index = model, data, index
        self.qpos = data.qpos[index.qpos]
        shape, every, tendons = index.actuators.shape, slice(0, 0), slice(0, 0)
        if index.actuators.size:
            every, tendons = rows(index.actuators.ravel()), rows(index.tendons)
        # Views into the engine's memory: they stay current, and cost nothing to look up in a loop.
        self.control = data.ctrl[every].reshape(shape)
        states = data.act[index.states]
        self.pressure = states.reshape(-1 if states.size else 0, shape[1])
        self._length, self._velocity = data.ten_length[tendons], data.ten_velocity[tendons]
        self._force = data.actuator_force[every].reshape(shape)
        self.straight_lengths = np.array([group.length for group in arm.groups for _ in range(group.routing.count)])
        self._zero, self._by_angle, self._twisting = index.zero, index.by_angle, index.twisting
        self._parallel = not index.straight.any()
        self._follow(arm)

    def _follow(self, arm: Arm) -> None:
        self.arm = arm
        tendons = self.index.tendons
        self.damping = self.model.tendon_damping[tendons] if tendons.size else np.zeros(len(self._zero))
        self.springs, self.twisted, self.helices = self.model.jnt_stiffness[self.index.joints].copy(), None, None
        if self._twisting.size:
            self.untwisting = np.array([
                (section.torsional_stiffness or 0.0) / section.link_pitch
                for section in (arm.sections[number] for number in self.index.section_of_joint[self._twisting])
            ])  # fmt: skip
            self.springs[self._twisting] = self.untwisting
            if not self.index.straight.all() and self.index.actuators.size:
                self.helices = TwistedMuscles(arm, self.index, self.qpos)
                self.twisted = None if self.actuation == "lengths" else self.helices

    @property
    def muscle_lengths(self) -> Array:
        """Muscle lengths [m], shape (M,), as the engine measures them, and what twist adds to parallel muscles."""
        if not self.index.tendons.size:
            return self.straight_lengths + self._by_angle @ self.qpos
        lengths = self._length + self._zero
        return lengths if self.twisted is None else lengths + self.twisted.stretch().sum(axis=1)

    @property
    def muscle_jacobian(self) -> Array:
        """What muscle lengths gain by joint angles [m/rad], shape (M, dofs)."""
        if self.twisted is not None and self._parallel:
            return self.twisted.jacobian()
        if self._parallel or not self.index.tendons.size:  # straight spans that nothing pulls have no part in it
            return self._by_angle
        J = tendon_jacobian(self.model, self.data)[self.index.tendons, self.index.dofs]
        if self.twisted is not None:
            J[~self.index.straight] = self.twisted.jacobian()[~self.index.straight]
        return J

    @property
    def muscle_tensions(self) -> Array:
        """Muscle tensions [N], pulling > 0, shape (M,): `actuator_tensions` and what stretched silicone pulls with."""
        if not self.index.tendons.size:
            return np.zeros(len(self._zero))
        engine = self._length + self._zero
        tensions = self.actuator_tensions + passive_tension(engine, self.arm)
        if self.twisted is not None:
            tensions = tensions + self.muscle_slopes * self.twisted.stretch().sum(axis=1)
        return tensions

    @property
    def actuator_tensions(self) -> Array:
        """What actuators and damping along the muscles pull with [N], pulling > 0, shape (M,).

        Actuators do not push; damping does where a slack muscle shortens.
        """
        return self.damping * self._velocity - self._force.sum(axis=0)

    @property
    def servo_pulls(self) -> Array:
        """What the actuators alone pull with [N], pulling > 0, shape (M,)."""
        return np.asarray(-self._force.sum(axis=0))

    @property
    def muscle_slopes(self) -> Array:
        """What tensions gain by length [N/m], shape (M,), controls and pressures as they are."""
        model, data = self.model, self.data
        if not self.index.tendons.size:
            return np.zeros(len(self._zero))
        lengths = self.muscle_lengths
        silicone = passive_slope(lengths, self.arm)
        if len(self.pressure):
            return force_slope(self.pressure[0], lengths, self.arm) + silicone
        own = self.index.actuators.ravel()
        (low, high), force = model.actuator_forcerange[own].T, data.actuator_force[own]
        at_limit = (model.actuator_forcelimited[own] != 0) & ((force <= low) | (force >= high))
        return np.where(at_limit, 0.0, -model.actuator_biasprm[own, 1]) + silicone

    def stiffen_twist(self) -> None:
        """Let twisted parallel muscles stiffen the engine's joints by their present tensions, as fixed tendons do not.

        In motion that is all that twist does to them, and at rest under length servos, which measure what the engine
        does. Under tensions and pressures statics also have what a muscle's longer way does to tension and to bending:
        0.1 to 0.3 % of length at the tip of an arm twisted by 30 deg, more where tensions are high.
        """
        if self.helices is not None:
            added = self.helices.joint_stiffness(self.muscle_tensions)
            self.model.jnt_stiffness[self.index.joints][self._twisting] = self.untwisting + added

    def tighten(self, tensions: Array) -> None:
        """Let tensions [N], shape (M,), stiffen the twisting joints' `springs`, where no `twisted` does it all."""
        if self.helices is not None and self.twisted is None:
            self.springs[self._twisting] = self.untwisting + self.helices.joint_stiffness(tensions)

    @property
    def twist_by_tension(self) -> Array | float:
        """What a newton of each muscle adds to the moment against twist by `tighten` [m], shape (M, dofs), or 0."""
        if self.helices is None or self.twisted is not None:
            return 0.0
        return self.helices.against_twist()

    @property
    def turning(self) -> bool:
        """Whether `stiffen_twist` does anything."""
        return self.helices is not None

    @property
    def muscle_paths(self) -> Array:
        """Points that muscles run through, one a station [m], shape (M, links + 1, 3); NaN where a muscle is not."""
        local = np.array([[*point, 0.0] for group in self.arm.groups for point in group.routing.points])
        rotations, base = self.data.xmat[self.index.stations].reshape(-1, 3, 3), self.data.xpos[self.index.base]
        points = self.data.xpos[self.index.stations] + np.einsum("sij,mj->msi", rotations, local.reshape(-1, 3))
        axes, starts = rotations[:, :, 2], section_stations(self.arm)
        for group, muscles in zip(self.arm.groups, self.index.groups, strict=True):
            first, last = starts[group.first], starts[group.section + 1]
            if group.routing.path == "spans":
                for number in range(group.first, group.section + 1):
                    own = slice(starts[number], starts[number + 1])
                    points[muscles, own] += self.arm.sections[number].guide_height * axes[own]
            points[muscles, :first] = points[muscles, last + 1 :] = np.nan
        if self.index.base_pose.size:  # in a host
            points = (points - base) @ rotations[0]
        return points

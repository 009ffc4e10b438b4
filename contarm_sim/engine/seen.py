"""What is seen of many arms in the engine, each to the bits of a `Plant` of its own."""

from __future__ import annotations

from functools import cached_property
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch

from contarm_sim.engine.driven import DrivenMuscles
from contarm_sim.engine.index import ArmIndex, rows
from contarm_sim.engine.models import Built
from contarm_sim.engine.twist import TwistedMuscles
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import passive_tension
from contarm_sim.mjcf import Actuation
from contarm_sim.model.arm import Arm

FIELDS = ("xpos", "xmat", "sensordata", "ten_length", "ten_velocity", "actuator_force")
"""What the engine derives of a state that is kept here."""


class SeenArms:
    """B arms, M muscles each, as the engine last derived them; see `Plants`, which says what its attributes are."""

    arms: list[Arm]
    models: list[mujoco.MjModel]
    batch: Batch
    index: ArmIndex
    centres: Array
    zero: Array
    damping: Array
    actuation: Actuation
    control: Array
    sensors: Array
    _own: list[Built]
    _numbers: Array
    _last: Array
    _fields: dict[str, Any]
    _force: Array
    _tendons: slice
    _laws: dict[Any, list[int]]

    def _views(self) -> None:
        batch, index = self.batch, self.index
        self._fields = {name: batch.bind(name) for name in FIELDS}
        shape = (len(self.arms), *index.actuators.shape)
        every = rows(index.actuators.ravel())
        self._tendons = rows(index.tendons) if index.actuators.size else slice(0, 0)
        every_control, every_force = batch.bind("ctrl")[:, every], self._fields["actuator_force"][:, every]
        self.control, self._force = every_control.reshape(shape), every_force.reshape(shape)
        if shape[1] == 1:
            self.control = self.control[:, 0]
        self.centres, self.sensors = self._fields["xpos"][:, index.stations], self._fields["sensordata"]
        self._numbers, self._last = batch.warning[:, :, 1], batch.warning[:, :, 0]  # the engine's mjWarningStat

    def _stack(self) -> None:
        """Bring what is kept of all arms up to date with them."""
        self.batch.set_models(self.models)
        self.zero = np.stack([own.index.zero for own in self._own])
        self.damping = np.zeros(self.zero.shape)
        if self.index.actuators.size:
            self.damping = np.stack([model.tendon_damping[self._tendons] for model in self.models])
        self._laws: dict[Any, list[int]] = {}
        for place, arm in enumerate(self.arms):
            self._laws.setdefault(tuple((group.law, group.rest_length) for group in arm.groups), []).append(place)
        vars(self).pop("_twist", None)

    @cached_property
    def _twist(self) -> tuple[TwistedMuscles | None, Array]:
        """The muscles as twist finds them, and what joints resist twist with of themselves [N m/rad], shape (B, J).

        Found when they are asked for: it takes longer than all else that a change of arms does.
        """
        if not self.one(0).turning:
            return None, np.empty((len(self.arms), 0))
        singles = [self.one(place) for place in range(len(self.arms))]
        helices = TwistedMuscles.of_many([one.helices for one in singles if one.helices], self.qpos)
        return helices, np.stack([one.untwisting for one in singles])

    @property
    def _helices(self) -> TwistedMuscles | None:
        return self._twist[0]

    @property
    def _untwisting(self) -> Array:
        return self._twist[1]

    @property
    def twisted(self) -> TwistedMuscles | None:
        """What twist does to parallel muscles, as of `Plant`."""
        return None if self.actuation == "lengths" else self._helices

    @property
    def state(self) -> Array:
        """All that an arm goes on from, as of `mjSTATE_INTEGRATION`, a view, shape (B, size): copies of rows last."""
        return np.asarray(self.batch.state)

    @property
    def qpos(self) -> Array:
        """Joint angles [rad], a view, shape (B, D)."""
        return self.batch.bind("qpos")[:, self.index.qpos]

    @property
    def qvel(self) -> Array:
        """Rates of the joint angles [rad/s], a view, shape (B, D)."""
        return self.batch.bind("qvel")[:, self.index.dofs]

    @property
    def pressure(self) -> Array:
        """Pressures behind the valves [Pa], a view of the form of `control`; empty for servos."""
        states, (several, count) = self.index.states, self.index.actuators.shape
        shape = (several, count) if states.stop > states.start else (0, count)
        return self.batch.bind("act")[:, states].reshape(len(self.arms), *(shape[1:] if shape[0] == 1 else shape))

    def one(self, place: int) -> DrivenMuscles:
        """Return what `Plant` has of its muscles, of one of the arms; views that stay current until `become`."""
        batch, fields = self.batch, self._fields
        names = ("ten_length", "ten_velocity", "actuator_force")
        data: Any = SimpleNamespace(
            ctrl=batch.bind("ctrl")[place], act=batch.bind("act")[place], qpos=batch.bind("qpos")[place],
            **{name: fields[name][place] for name in names},
        )  # fmt: skip
        return DrivenMuscles(self.arms[place], self.models[place], data, self._own[place].index, self.actuation)

    @property
    def stations(self) -> Array:
        """Centres of base plate, disks and tip plate [m], shape (B, K, 3)."""
        return self.centres.copy()

    @property
    def tip(self) -> Array:
        """Tip positions [m], shape (B, 3)."""
        return self.centres[:, -1].copy()

    @property
    def rotations(self) -> Array:
        """Orientations of base plate, links and tip, shape (B, K, 3, 3)."""
        return self._fields["xmat"][:, self.index.stations].reshape(len(self.arms), -1, 3, 3).copy()

    @property
    def muscle_lengths(self) -> Array:
        """Muscle lengths [m], shape (B, M), as of `Plant`."""
        if not self.index.tendons.size:
            return np.stack([self.one(place).muscle_lengths for place in range(len(self.arms))])
        lengths = self._fields["ten_length"][:, self._tendons] + self.zero
        return lengths if self.twisted is None else lengths + self.twisted.stretch().sum(axis=-1)

    @property
    def muscle_tensions(self) -> Array:
        """Muscle tensions [N], pulling > 0, shape (B, M), as of `Plant`."""
        if not self.index.tendons.size:
            return np.zeros(self.zero.shape)
        if self.twisted is not None:  # what tensions gain by length depends on actuators in many ways
            return np.stack([self.one(place).muscle_tensions for place in range(len(self.arms))])
        return self.actuator_tensions + self._silicone(self._fields["ten_length"][:, self._tendons] + self.zero)

    @property
    def actuator_tensions(self) -> Array:
        """What actuators and damping along the muscles pull with [N], pulling > 0, shape (B, M)."""
        return self.damping * self._fields["ten_velocity"][:, self._tendons] - self._force.sum(axis=1)

    def _silicone(self, lengths: Array) -> Array:
        """Return what stretched silicone pulls with [N], shape (B, M)."""
        if len(self._laws) == 1:
            return passive_tension(lengths, self.arms[0])
        pulled = np.empty(lengths.shape)
        for places in self._laws.values():
            pulled[places] = passive_tension(lengths[places], self.arms[places[0]])
        return pulled

    @property
    def turning(self) -> bool:
        """Whether `stiffen_twist` does anything."""
        return self._helices is not None

    def stiffen_twist(self) -> None:
        """Let twisted parallel muscles stiffen the engine's joints by their present tensions: see `DrivenMuscles`."""
        if self._helices is None:
            return
        stiffness, twisting = (
            self._untwisting + self._helices.joint_stiffness(self.muscle_tensions),
            self.index.twisting,
        )
        for model, own in zip(self.models, stiffness, strict=True):
            model.jnt_stiffness[twisting] = own
        self.batch.set_models(self.models)

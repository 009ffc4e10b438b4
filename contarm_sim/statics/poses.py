"""Many poses of arms of one structure at once: what statics ask of a plant, with a leading axis of cases.

The engine derives frames, muscle lengths and forces case by case, which takes microseconds; all else is arithmetic on
arrays, whose cost beside Python's own is what many cases share.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.index import rows
from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import force_slope, passive_slope, passive_tension
from contarm_sim.mjcf.stability import tendon_jacobian

Rows = NDArray[np.integer] | NDArray[np.bool_]

_WEIGHT = ("body_mass", "body_inertia", "body_subtreemass")
"""What the engine knows of masses as far as the mass matrix depends on it."""

_WRITTEN = ("springs", "untwisting", "gravity", "gain", "bias", "dof_damping", "damping", *_WEIGHT)
"""What arms of one structure differ in that a pose at rest depends on."""


@dataclass(frozen=True)
class Starts:
    """C cases of arms of one structure, before they come to rest.

    Attributes:
        qpos: joint angles to start from [rad], shape (C, dofs).
        control: controls of the M muscles, shape (C, M); M is 0 where nothing drives them.
        arms: which of the arms each case is, shape (C,); None: the plant's own, all of them.
        written: of each arm, what `written` returned.
        tolerance: largest generalised force left at rest [N m], shape (C,) or one for all.
    """

    qpos: Array
    control: Array
    arms: NDArray[np.integer] | None = None
    written: tuple[dict[str, Array], ...] = ()
    tolerance: Array | float = 0.0


def written(plant: Plant) -> dict[str, Array]:
    """Return copies of what the plant's arm has of its own within its structure."""
    model = plant.model
    found = {"springs": plant.springs, "gravity": plant.gravity, "gain": model.actuator_gainprm,
             "bias": model.actuator_biasprm, "dof_damping": model.dof_damping, "damping": plant.damping,
             **{name: getattr(model, name) for name in _WEIGHT}}  # fmt: skip
    if plant.helices is not None:
        found["untwisting"] = plant.untwisting
    return {name: np.array(value) for name, value in found.items()}


class Poses:
    """C poses, moved by their `qpos`; attributes and properties are those of `Plant`, with a leading axis of cases.

    Args:
        plant: of the structure; its engine derives the poses one after the other.
        starts: the cases.

    Attributes:
        data: what the engine derived of each case, under its names.
        gain, bias: of the engine's actuators.
    """

    springs: Array
    untwisting: Array
    gravity: Array
    gain: Array
    bias: Array
    dof_damping: Array
    damping: Array
    body_mass: Array
    body_inertia: Array
    body_subtreemass: Array

    def __init__(self, plant: Plant, starts: Starts) -> None:
        self._plant, self.model, self.index = plant, plant.model, plant.index
        self.arm, self.actuation = plant.arm, plant.actuation
        model, data, index, count = plant.model, plant.data, plant.index, len(starts.qpos)
        plant.pose()  # at rest, rates and velocities zero, whoever had it before
        self.qpos = np.array(starts.qpos)
        self.control = np.zeros((count, model.nu))
        self._zero, self._straight, self._driven = index.zero, index.straight, bool(model.ntendon)
        if model.nu:
            self._every, self._tendons = rows(index.actuators.ravel()), rows(index.tendons)
            self.control[:, self._every] = np.tile(starts.control, index.actuators.shape[0])
        self.pressure = np.tile(starts.control, model.na // len(self._zero)) if model.na else np.zeros((count, 0))
        own = [written(plant)] if starts.arms is None else starts.written
        self._differ = starts.arms is not None and len(starts.written) > 1
        which = np.zeros(count, dtype=int) if starts.arms is None else starts.arms
        for name in _WRITTEN:
            if name in own[0]:
                setattr(self, name, np.stack([one[name] for one in own])[which])
        self.gravity = self.gravity[:, None, :]
        names = ["xaxis", "xanchor", "xipos", "xpos", "xmat"]
        if self._driven:
            names += ["ten_length", "actuator_force", "actuator_length"]
            names += ["site_xpos"] * bool(index.straight.any())
        self._views = {name: getattr(data, name) for name in names}
        self._kept: dict[str, Array] = {name: np.empty((count, *view.shape)) for name, view in self._views.items()}
        self._jacobians = np.empty((count, len(self._zero), model.nv)) if "site_xpos" in names else None
        self.helices = plant.helices
        self._follow()

    def _follow(self) -> None:
        count = len(self.qpos)
        kept = {name: array[:count] for name, array in self._kept.items()}
        self.data: Any = SimpleNamespace(qpos=self.qpos, ctrl=self.control, **kept)
        if self.helices is not None:
            self.helices = self.helices.at(self.qpos)
        self.twisted = None if self.actuation == "lengths" else self.helices

    def keep(self, rows: Rows) -> None:
        """Go on with these of the cases alone; `pose` them next."""
        self.qpos, self.control, self.pressure = self.qpos[rows], self.control[rows], self.pressure[rows]
        for name in _WRITTEN:
            if hasattr(self, name):
                setattr(self, name, getattr(self, name)[rows])
        self._follow()

    @contextmanager
    def engine_at(self, row: int) -> Iterator[tuple[mujoco.MjModel, mujoco.MjData]]:
        """Yield the engine's model and data, at joint angles and masses of one of the cases; nothing is derived."""
        before = {name: getattr(self.model, name).copy() for name in _WEIGHT}
        self._plant.data.qpos[:] = self.qpos[row]
        try:
            for name in _WEIGHT:
                getattr(self.model, name)[:] = getattr(self, name)[row]
            yield self.model, self._plant.data
        finally:
            for name, value in before.items():
                getattr(self.model, name)[:] = value

    def tip_jacobian(self, row: int) -> Array:
        """Return the tip's velocity and rotation [m/s, rad/s] by joint rates of one of the cases, shape (6, dofs)."""
        with self.engine_at(row) as (model, data):
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            return self._plant.tip_jacobian()

    @property
    def mass(self) -> Array:
        """Masses of the links and the payload [kg], shape (C, K)."""
        return self.body_mass[:, self.index.bodies]

    def __len__(self) -> int:
        return len(self.qpos)

    def pose(self, actuated: bool = True) -> None:
        """Derive what forces at rest need of the present joint angles, as `Plant.pose` does.

        Args:
            actuated: whether muscles pull as their controls say; else lengths alone are derived of them.
        """
        model, data = self.model, self._plant.data
        kinematics, tendon, transmission = mujoco.mj_kinematics, mujoco.mj_tendon, mujoco.mj_transmission
        actuation, driven, pressed, differ = mujoco.mj_fwdActuation, self._driven, bool(model.na), self._differ
        gain, bias = model.actuator_gainprm, model.actuator_biasprm
        qpos, ctrl, act, jacobians = data.qpos, data.ctrl, data.act, self._jacobians
        pairs = [(view, getattr(self.data, name)) for name, view in self._views.items()]
        for i in range(len(self.qpos)):
            qpos[:] = self.qpos[i]
            kinematics(model, data)
            if driven:
                ctrl[:] = self.control[i]
                if pressed:
                    act[:] = self.pressure[i]
                if differ:
                    gain[:], bias[:] = self.gain[i], self.bias[i]
                if jacobians is not None:
                    mujoco.mj_comPos(model, data)
                tendon(model, data)
                if actuated:
                    transmission(model, data)
                    actuation(model, data)
                if jacobians is not None:
                    jacobians[i] = tendon_jacobian(model, data)
            for view, kept in pairs:
                kept[i] = view

    @property
    def _engine_lengths(self) -> Array:
        return np.asarray(self.data.ten_length[:, self._tendons] + self._zero)

    @property
    def muscle_lengths(self) -> Array:
        """Muscle lengths [m], shape (C, M)."""
        if not self._driven:
            return self._plant.straight_lengths + (self.index.by_angle @ self.qpos[..., None])[..., 0]
        lengths = self._engine_lengths
        return lengths if self.twisted is None else lengths + self.twisted.stretch().sum(axis=-1)

    @property
    def muscle_jacobian(self) -> Array:
        """What muscle lengths gain by joint angles [m/rad], shape (C, M, dofs), or (M, dofs) where it is the same."""
        if self.twisted is not None and not self._straight.any():
            return self.twisted.jacobian()
        if self._jacobians is None:
            return self.index.by_angle
        J = self._jacobians[: len(self)]
        if self.twisted is not None:
            J[:, ~self._straight] = self.twisted.jacobian()[:, ~self._straight]
        return J

    @property
    def muscle_tensions(self) -> Array:
        """Muscle tensions [N], pulling > 0, shape (C, M)."""
        if not self._driven:
            return np.zeros((len(self), len(self._zero)))
        forces = self.data.actuator_force[:, self._every].reshape(len(self), -1, len(self._zero))
        tensions = 0.0 - forces.sum(axis=-2) + passive_tension(self._engine_lengths, self.arm)
        if self.twisted is not None:
            tensions = tensions + self.muscle_slopes * self.twisted.stretch().sum(axis=-1)
        return np.asarray(tensions)

    @property
    def muscle_slopes(self) -> Array:
        """What tensions gain by length [N/m], shape (C, M)."""
        if not self._driven:
            return np.zeros((len(self), len(self._zero)))
        lengths = self.muscle_lengths
        silicone = passive_slope(lengths, self.arm)
        if self.pressure.size:
            return force_slope(self.pressure[:, : len(self._zero)], lengths, self.arm) + silicone
        slopes = np.where(self.at_limit, 0.0, -self.bias[:, :, 1])
        return np.asarray(slopes + silicone)

    @property
    def at_limit(self) -> NDArray[np.bool_]:
        """Whether each actuator is at a limit of its force, shape (C, actuators)."""
        low, high = self.model.actuator_forcerange.T
        force = self.data.actuator_force
        return (self.model.actuator_forcelimited != 0) & ((force <= low) | (force >= high))

    def tighten(self, tensions: Array) -> None:
        """Let tensions [N], shape (C, M), stiffen twisting joints' `springs`, as `Plant.tighten` does."""
        if self.helices is not None and self.twisted is None:
            self.springs[:, self.index.twisting] = self.untwisting + self.helices.joint_stiffness(tensions)

    @property
    def twist_by_tension(self) -> Array | float:
        """What a newton of each muscle adds to the moment against twist by `tighten` [m], shape (C, M, dofs), or 0."""
        if self.helices is None or self.twisted is not None:
            return 0.0
        return self.helices.against_twist()

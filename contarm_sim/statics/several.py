"""Poses of arms that differ in more than a compiled model lets them: each case is derived by a model of its own arm.

What they must have in common is how many links, hinges and muscles there are, and which muscle crosses which joint:
arms that a fit changes a little do. Arms that twist, whose muscles run straight or are stretched silicone, share a
model or are not together.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.models import structure
from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf.stability import tendon_jacobian
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Drive
from contarm_sim.statics.driving import DRIVEN
from contarm_sim.statics.equilibrium import reused
from contarm_sim.statics.poses import Poses, Starts, written


def alike(arm: Arm, kind: Drive, placed: bool = False) -> tuple[Any, ...]:
    """Return what arms driven alike must have in common to be posed together; it may be compared and hashed.

    Args:
        arm: one of them.
        kind: how its muscles are driven.
        placed: whether forces act at places of it, which sections of other lengths have elsewhere.
    """
    _, actuation = DRIVEN[kind]
    free = all(section.torsional_stiffness is None for section in arm.sections)
    plain = all(group.routing.path == "parallel" and group.law.passive_stiffness is None for group in arm.groups)
    if actuation == "pressures" or not (free and plain):
        return kind, structure(arm, actuation)
    groups = tuple((group.section, group.first, group.routing.count) for group in arm.groups)
    lengths = tuple(section.length for section in arm.sections) if placed else ()
    return kind, tuple(section.links for section in arm.sections), lengths, groups


class SeveralPoses(Poses):
    """Poses whose arms are `alike`, one model for each structure among them.

    Args:
        arms: of the cases.
        kind: how their muscles are driven.
    """

    def __init__(self, arms: Sequence[Arm], kind: Drive) -> None:
        self._kind = kind
        self._plants: dict[Any, Plant] = {}
        self._known: dict[int, tuple[Arm, Plant, dict[str, Array]]] = {}
        first = [self._of(arm) for arm in arms]
        plant, count = first[0][0], len(arms)
        control = np.zeros((count, len(plant.index.zero) if plant.model.nu else 0))
        starts = Starts(np.tile(plant.data.qpos, (count, 1)), control, np.arange(count), tuple(own for _, own in first))
        super().__init__(plant, starts)
        self._differ = True
        self._of_case = [plant for plant, _ in first]
        self._mixed = not plant.index.straight.any() and self.helices is None  # then each has arrays of its own
        self._names = list(self._views)
        self._view_of = {id(plant): [getattr(plant.data, name) for name in self._names] for plant in self._of_case}
        self._offset = np.stack([plant.index.zero for plant in self._of_case])
        self._by_angle = np.stack([plant.index.by_angle for plant in self._of_case])
        self._range = np.stack([plant.model.actuator_forcerange for plant in self._of_case])
        self._limited = np.stack([plant.model.actuator_forcelimited != 0 for plant in self._of_case])

    def _of(self, arm: Arm) -> tuple[Plant, dict[str, Array]]:
        found = self._known.get(id(arm))
        if found is None:
            pull_only, actuation = DRIVEN[self._kind]
            key = structure(arm, actuation)
            plant = self._plants.get(key)
            if plant is None:
                plant = self._plants[key] = reused(arm, pull_only, actuation)
                plant.reset()
                plant.pose()
            else:
                plant.become(arm)
            found = self._known[id(arm)] = arm, plant, written(plant)
        return found[1:]

    def plant_of(self, row: int) -> Plant:
        """Return the plant of a case, at its joint angles."""
        plant = self._of_case[row]
        plant.data.qpos[:] = self.qpos[row]
        return plant

    def become(self, row: int, arm: Arm) -> None:
        """Let a case have another arm, alike."""
        plant, own = self._of(arm)
        for name, value in own.items():
            getattr(self, name)[row] = value[None, :] if name == "gravity" else value
        self._of_case[row] = plant
        if id(plant) not in self._view_of:
            self._view_of[id(plant)] = [getattr(plant.data, name) for name in self._names]
        index, model = plant.index, plant.model
        self._offset[row], self._by_angle[row] = index.zero, index.by_angle
        self._range[row], self._limited[row] = model.actuator_forcerange, model.actuator_forcelimited != 0

    def send(self, row: int, control: Array) -> None:
        """Drive the muscles of a case by controls, shape (M,)."""
        if self.model.nu:
            self.control[row, self._every] = np.tile(control, self.index.actuators.shape[0])
        if self.pressure.size:
            self.pressure[row] = np.tile(control, self.pressure.shape[1] // len(control))

    def derive(self, rows: NDArray[np.integer]) -> None:
        """Derive the poses of these cases alone, as `pose` does of all."""
        kinematics, tendon, transmission = mujoco.mj_kinematics, mujoco.mj_tendon, mujoco.mj_transmission
        actuation, driven, pressed = mujoco.mj_fwdActuation, self._driven, bool(self.model.na)
        kept = [getattr(self.data, name) for name in self._names]
        for i in rows.tolist():
            plant = self._of_case[i]
            model, data = plant.model, plant.data
            data.qpos[:] = self.qpos[i]
            kinematics(model, data)
            if driven:
                data.ctrl[:] = self.control[i]
                if pressed:
                    data.act[:] = self.pressure[i]
                model.actuator_gainprm[:], model.actuator_biasprm[:] = self.gain[i], self.bias[i]
                if self._jacobians is not None:
                    mujoco.mj_comPos(model, data)
                tendon(model, data)
                transmission(model, data)
                actuation(model, data)
                if self._jacobians is not None:
                    self._jacobians[i] = tendon_jacobian(model, data)
            for view, to in zip(self._view_of[id(plant)], kept, strict=True):
                to[i] = view

    @property
    def _engine_lengths(self) -> Array:
        return np.asarray(self.data.ten_length[:, self._tendons] + self._offset)

    @property
    def muscle_lengths(self) -> Array:
        """Muscle lengths [m], shape (C, M)."""
        if not self._mixed:
            return super().muscle_lengths
        if not self._driven:
            return self._plant.straight_lengths + (self._by_angle @ self.qpos[..., None])[..., 0]
        return self._engine_lengths

    @property
    def muscle_jacobian(self) -> Array:
        """What muscle lengths gain by joint angles [m/rad], shape (C, M, dofs)."""
        return self._by_angle if self._mixed else super().muscle_jacobian

    @property
    def at_limit(self) -> NDArray[np.bool_]:
        """Whether each actuator is at a limit of its force, shape (C, actuators)."""
        low, high = self._range[..., 0], self._range[..., 1]
        force = self.data.actuator_force
        return np.asarray(self._limited & ((force <= low) | (force >= high)))

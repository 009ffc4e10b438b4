"""Recording: two copies a sample, unpacked when the run is over."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.engine.index import ArmIndex, rows
from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.mechanics.pneumatics import passive_tension, pressure_for
from contarm_sim.model.arm import Arm


class Recorder:
    """Keeps the plant's sensors and stations for up to `count` samples.

    Every small array operation beside `mj_step` costs microseconds, the caches being cold; so whatever the sensors
    already gather is copied in one piece.

    Attributes:
        sensed: sensors of the samples, shape (count, sensors).
        stations: of the samples in the engine's world [m], shape (count, links + 1, 3).
        muscles: where lengths [m], velocities [m/s] and forces [N] of the muscles are among the sensors.
    """

    def __init__(self, plant: Plant, count: int) -> None:
        model, data = plant.model, plant.data
        self._arm, self._damping, self._index = plant.arm, plant.damping, plant.index
        self._sensordata, self._centres = data.sensordata, plant.centres
        self.sensed = np.empty((count, model.nsensordata))
        self.stations = np.empty((count, *self._centres.shape))
        index = plant.index
        self.muscles = rows(np.concatenate([index.lengths, index.velocities, index.forces]))

    def take(self, index: int) -> None:
        """Keep what the engine last derived from a state: the one that `mj_step` started from, or `mj_forward` saw."""
        self.sensed[index] = self._sensordata
        self.stations[index] = self._centres

    def arrays(self, count: int) -> dict[str, Any]:
        """Return the first `count` samples, by the names that a trajectory has for them."""
        sensed, index = self.sensed[:count], self._index
        lengths = sensed[:, index.lengths] + index.zero
        pulled = passive_tension(lengths, self._arm) + sensed[:, index.velocities] * self._damping
        pulled = pulled - sensed[:, index.forces]
        arrays = {
            "muscle_lengths": lengths,
            "muscle_tensions": pulled,
            "pressure": pressure_for(pulled, lengths, self._arm),
            "stations": self.backbones(count),
            "tip_rotation": _rotations(sensed[:, index.tip_orientation]),
            "qpos": sensed[:, index.angles],
        }
        return arrays | moved(sensed, index, self._arm) | touched(sensed, index, self._arm)

    def backbones(self, count: int) -> Array:
        """Return the stations of the first `count` samples in the base frame [m], shape (count, links + 1, 3)."""
        stations = self.stations[:count]
        if not self._index.base_pose.size:
            return stations
        position, rotation = _base(self.sensed[:count], self._index)
        return np.asarray((stations - position[:, None]) @ rotation)


def moved(sensed: Array, index: ArmIndex, arm: Arm) -> dict[str, Any]:
    """Return where the base was in a host, where it can move, and the positions of the host's joints.

    Args:
        sensed: all sensors of T samples, shape (T, sensors).
    """
    host, found = arm.world.host, dict[str, Any]()
    if index.base_pose.size and host is not None and host.moves:
        found["base"] = sensed[:, index.base_pose]
    if index.host.size:
        found["host"] = sensed[:, index.host]
    return found


def touched(sensed: Array, index: ArmIndex, arm: Arm) -> dict[str, Any]:
    """Return what the arm touched, and where the free objects were, by a trajectory's names; nothing of an arm alone.

    Args:
        sensed: all sensors of T samples, shape (T, sensors).
    """
    found: dict[str, Any] = {}
    if len(index.touch):
        touch, depth = sensed[:, index.touch], sensed[:, index.depth]
        sample, partner, station = np.nonzero(touch[..., 0] > 0)
        felt, deepest = touch[sample, partner, station], depth[sample, partner, station]
        force, normal = 0.0 - felt[:, 1:4], 0.0 - deepest[:, 4:7]
        pressed = np.linalg.norm(force, axis=1) > 0
        point = np.where(pressed[:, None], felt[:, 4:7], deepest[:, 1:4])  # the mean by forces is 0 without any
        if index.base_pose.size:
            position, rotation = (part[sample] for part in _base(sensed, index))
            point, force, normal = (
                np.einsum("ci,cij->cj", each, rotation) for each in (point - position, force, normal)
            )
        found["contacts"] = Contacts(
            sample, station, partner, point=point, force=force, normal=normal,
            depth=-deepest[:, 0], names=arm.world.partners,
        )  # fmt: skip
    if len(index.poses):
        found["objects"] = sensed[:, index.poses]
    return found


def _base(sensed: Array, index: ArmIndex) -> tuple[Array, Array]:
    """Return the base's positions [m], (T, 3), and rotations, (T, 3, 3), in a host."""
    pose = sensed[:, index.base_pose]
    return pose[:, :3], _rotations(pose[:, 3:])


def _rotations(quaternions: Array) -> Array:
    """Return rotation matrices, shape (T, 3, 3), of unit quaternions w x y z, shape (T, 4)."""
    w, v = quaternions[:, 0, None, None], quaternions[:, 1:]
    cross = np.zeros((len(v), 3, 3))
    cross[:, [2, 0, 1], [1, 2, 0]] = v
    cross[:, [1, 2, 0], [2, 0, 1]] = -v
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross

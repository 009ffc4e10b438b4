"""Recording: two copies a sample, unpacked when the run is over."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.engine.index import ArmIndex, rows
from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.contacts import Contacts, contact_names
from contarm_sim.mechanics.pneumatics import passive_tension, pressure_for
from contarm_sim.model.arm import Arm


class Recorder:
    """Keeps the plant's sensors and stations for up to `count` samples.

    Every small array operation beside `mj_step` costs microseconds, the caches being cold; so whatever the sensors
    already gather is copied in one piece.

    Attributes:
        sensed: sensors of the samples, shape (count, sensors).
        stations: of the samples [m], shape (count, links + 1, 3).
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
        return {
            "muscle_lengths": lengths,
            "muscle_tensions": pulled,
            "pressure": pressure_for(pulled, lengths, self._arm),
            "stations": self.stations[:count],
            "tip_rotation": _rotations(sensed[:, index.tip_orientation]),
            "qpos": sensed[:, index.angles],
        } | touched(sensed, index, self._arm)


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
        found["contacts"] = Contacts(
            sample, station, partner, point=felt[:, 4:7], force=-felt[:, 1:4], normal=-deepest[:, 1:4],
            depth=-deepest[:, 0], names=contact_names(arm),
        )  # fmt: skip
    if len(index.poses):
        found["objects"] = sensed[:, index.poses]
    return found


def _rotations(quaternions: Array) -> Array:
    """Return rotation matrices, shape (T, 3, 3), of unit quaternions w x y z, shape (T, 4)."""
    w, v = quaternions[:, 0, None, None], quaternions[:, 1:]
    cross = np.zeros((len(v), 3, 3))
    cross[:, [2, 0, 1], [1, 2, 0]] = v
    cross[:, [1, 2, 0], [2, 0, 1]] = -v
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross

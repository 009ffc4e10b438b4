"""Recording: two copies a sample, unpacked when the run is over."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import passive_tension, pressure_for
from contarm_sim.mjcf.routing import counted_from


class Recorder:
    """Keeps the plant's sensors and stations for up to `count` samples.

    Every small array operation beside `mj_step` costs microseconds, the caches being cold; so whatever the sensors
    already gather is copied in one piece.

    Attributes:
        sensed: sensors of the samples, shape (count, sensors).
        stations: of the samples [m], shape (count, links + 1, 3).
        muscles: where lengths [m], velocities [m/s] and forces [N] of the muscles are among the sensors, nine numbers.
        zero: what the engine's muscle lengths are counted from [m].
    """

    def __init__(self, plant: Plant, count: int) -> None:
        model, data = plant.model, plant.data
        self._arm, self._damping = plant.arm, plant.damping
        self._sensordata, self._centres = data.sensordata, plant.centres
        self.sensed = np.empty((count, model.nsensordata))
        self.stations = np.empty((count, plant.arm.links + 1, 3))
        self._column = {model.sensor(i).name: int(model.sensor_adr[i]) for i in range(model.nsensor)}
        self.muscles, self.zero = self._slice("muscle_1_length", 9), counted_from(plant.arm)
        self._angles = slice(int(model.sensor_adr[model.nsensor - model.njnt]), model.nsensordata)

    def _slice(self, first: str, size: int) -> slice:
        return slice(self._column[first], self._column[first] + size)

    def take(self, index: int) -> None:
        """Keep what the engine last derived from a state: the one that `mj_step` started from, or `mj_forward` saw."""
        self.sensed[index] = self._sensordata
        self.stations[index] = self._centres

    def arrays(self, count: int) -> dict[str, Any]:
        """Return the first `count` samples: lengths, tensions, pressures, stations, tip rotations and joint angles."""
        sensed = self.sensed[:count]
        length, velocity, force = (self._slice(f"muscle_1_{name}", 3) for name in ("length", "velocity", "force"))
        lengths = sensed[:, length] + self.zero
        pulled = passive_tension(lengths, self._arm) + sensed[:, velocity] * self._damping - sensed[:, force]
        return {
            "muscle_lengths": lengths,
            "muscle_tensions": pulled,
            "pressure": pressure_for(pulled, lengths, self._arm),
            "stations": self.stations[:count],
            "tip_rotation": _rotations(sensed[:, self._slice("tip_orientation", 4)]),
            "qpos": sensed[:, self._angles].copy(),
        }


def _rotations(quaternions: Array) -> Array:
    """Return rotation matrices, shape (T, 3, 3), of unit quaternions w x y z, shape (T, 4)."""
    w, v = quaternions[:, 0, None, None], quaternions[:, 1:]
    cross = np.zeros((len(v), 3, 3))
    cross[:, [2, 0, 1], [1, 2, 0]] = v
    cross[:, [1, 2, 0], [2, 0, 1]] = -v
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross

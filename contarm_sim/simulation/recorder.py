"""Recording: two copies a sample, unpacked when the run is over."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import passive_tension, pressure_for
from contarm_sim.mjcf.routing import counted_from
from contarm_sim.simulation.plant import Plant
from contarm_sim.simulation.samples import Samples


class Recorder:
    """Keeps the plant's sensors and stations for up to `count` samples.

    Every small array operation beside `mj_step` costs microseconds, the caches being cold; so whatever the sensors
    already gather is copied in one piece.

    Attributes:
        lengths: muscle lengths when last taken [m], shape (3,).
        tip: tip position as the engine last derived it [m], shape (3,); a view that stays current.
        tensions: by actuators and damping when last taken [N], pulling > 0, shape (3,).
        pulls: by actuators alone when last taken [N], shape (3,).
    """

    def __init__(self, plant: Plant, count: int) -> None:
        model, data = plant.model, plant.data
        self._arm = plant.arm
        self._sensordata = data.sensordata
        self._centres = plant.centres
        self.tip = self._centres[-1]
        self._sensed = np.empty((count, model.nsensordata))
        self._stations = np.empty((count, plant.arm.links + 1, 3))
        self._column = {model.sensor(i).name: int(model.sensor_adr[i]) for i in range(model.nsensor)}
        self._damping, self._zero = plant.damping, counted_from(plant.arm)
        self._length, self._velocity, self._force = (
            self._sensordata[self._slice(f"muscle_1_{name}", 3)] for name in ("length", "velocity", "force")
        )
        self.lengths, self.tensions, self.pulls = np.empty(3), np.empty(3), np.empty(3)
        self._angles = slice(int(model.sensor_adr[model.nsensor - model.njnt]), model.nsensordata)

    def _slice(self, first: str, size: int) -> slice:
        return slice(self._column[first], self._column[first] + size)

    def take(self, index: int) -> None:
        """Keep what the engine last derived from a state: the one that `mj_step` started from, or `mj_forward` saw."""
        self._sensed[index] = self._sensordata
        self._stations[index] = self._centres
        np.add(self._length, self._zero, out=self.lengths)
        np.negative(self._force, out=self.pulls)
        np.multiply(self._velocity, self._damping, out=self.tensions)
        np.add(self.tensions, self.pulls, out=self.tensions)

    def samples(self, count: int, time: Array, target: Array, bend: Array, setpoint: Array) -> Samples:
        """Return the first `count` samples; the other arrays, of at least that length, are passed through."""
        sensed = self._sensed[:count]
        length, velocity, force = (self._slice(f"muscle_1_{name}", 3) for name in ("length", "velocity", "force"))
        lengths = sensed[:, length] + self._zero
        pulled = passive_tension(lengths, self._arm) + sensed[:, velocity] * self._damping - sensed[:, force]
        return Samples(
            time=time[:count],
            target=target[:count],
            bend=bend[:count],
            setpoint=setpoint[:count],
            muscle_lengths=lengths,
            muscle_tensions=pulled,
            pressure=pressure_for(pulled, lengths, self._arm),
            stations=self._stations[:count],
            tip_rotation=_rotations(sensed[:, self._slice("tip_orientation", 4)]),
            qpos=sensed[:, self._angles].copy(),
        )


def _rotations(quaternions: Array) -> Array:
    """Return rotation matrices, shape (T, 3, 3), of unit quaternions w x y z, shape (T, 4)."""
    w, v = quaternions[:, 0, None, None], quaternions[:, 1:]
    cross = np.zeros((len(v), 3, 3))
    cross[:, [2, 0, 1], [1, 2, 0]] = v
    cross[:, [1, 2, 0], [2, 0, 1]] = -v
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross

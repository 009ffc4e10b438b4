"""Recording: two copies a sample, unpacked when the run is over."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import passive_tension, pressure_for
from contarm_sim.simulation.plant import Plant
from contarm_sim.simulation.samples import Samples


class Recorder:
    """Keeps the plant's sensors and stations for up to `count` samples.

    Every small array operation beside `mj_step` costs microseconds, the caches being cold; so whatever the sensors
    already gather is copied in one piece.

    Attributes:
        lengths: muscle lengths as the sensors last read them [m], shape (3,); a view that stays current.
        tip: tip position as the engine last derived it [m], shape (3,); a view that stays current.
        forces: the actuators' forces as the sensors last read them [N], pulling < 0, shape (3,); such a view too.
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
        self.lengths = self._sensordata[self._slice("muscle_1_length", 3)]
        self.forces = self._sensordata[self._slice("muscle_1_force", 3)]
        self._angles = slice(int(model.sensor_adr[model.nsensor - model.njnt]), model.nsensordata)

    def _slice(self, first: str, size: int) -> slice:
        return slice(self._column[first], self._column[first] + size)

    def take(self, index: int) -> None:
        """Keep what the engine last derived from a state: the one that `mj_step` started from, or `mj_forward` saw."""
        self._sensed[index] = self._sensordata
        self._stations[index] = self._centres

    def samples(self, count: int, time: Array, target: Array, bend: Array, setpoint: Array) -> Samples:
        """Return the first `count` samples; the other arrays, of at least that length, are passed through."""
        sensed = self._sensed[:count]
        lengths = sensed[:, self._slice("muscle_1_length", 3)].copy()
        pulled = passive_tension(lengths, self._arm) - sensed[:, self._slice("muscle_1_force", 3)]
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

"""What a simulation leaves behind: arrays with stated shapes, on disk as one .npz."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.results.reading import Shape, read_arrays

SHAPES: dict[str, Shape] = {
    "time": ("T",), "target": ("T", 3), "bend": ("T", 2), "setpoint": ("T", 3), "muscle_lengths": ("T", 3),
    "muscle_tensions": ("T", 3), "pressure": ("T", 3), "stations": ("T", "S", 3), "tip_rotation": ("T", 3, 3),
    "qpos": ("T", "D"),
}  # fmt: skip
"""Shapes of the arrays: T samples, S stations, D joint angles."""


@dataclass(frozen=True)
class Samples:
    """T sampled states of an arm with N links; every quantity belongs to the sampled time, in the base frame.

    Attributes:
        time: simulated time [s], shape (T,); zeros for poses at rest.
        target: tip positions asked for [m], shape (T, 3).
        bend: commanded bends [rad], shape (T, 2).
        setpoint: the servos' controls, length changes [m], or pressures asked for [Pa] from the `pressure` controller,
            shape (T, 3).
        muscle_lengths: measured [m], shape (T, 3).
        muscle_tensions: measured [N], pulling > 0, shape (T, 3): by actuators, silicone, and damping along the muscle,
            which resists a slack muscle's shortening and so may push.
        pressure: gauge pressures of the muscles [Pa], shape (T, 3); under length servos, those that McKibben muscles of
            these lengths would need for these tensions, inf where none does it.
        stations: centres of base plate, disks and tip plate [m], shape (T, N + 1, 3).
        tip_rotation: orientation of the tip, shape (T, 3, 3).
        qpos: joint angles [rad], shape (T, dofs).
    """

    time: Array
    target: Array
    bend: Array
    setpoint: Array
    muscle_lengths: Array
    muscle_tensions: Array
    pressure: Array
    stations: Array
    tip_rotation: Array
    qpos: Array

    def __len__(self) -> int:
        return len(self.time)

    def save(self, path: Path) -> None:
        """Write the arrays to a compressed .npz under their own names."""
        np.savez_compressed(path, **{item.name: getattr(self, item.name) for item in fields(self)})

    @classmethod
    def load(cls, path: str | Path) -> Samples:
        """Read what `save` wrote.

        Raises:
            InputError: not such a file; an array is missing, of another shape or not finite (pressures may be inf).
        """
        return cls(**read_arrays(path, SHAPES))

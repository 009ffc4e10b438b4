"""What a simulation leaves behind: arrays with stated shapes, on disk as one .npz."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, fields
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array

_BROKEN = (OSError, EOFError, ValueError, TypeError, RuntimeError, MemoryError, BadZipFile, zlib.error, struct.error)
"""What a file that is no .npz, or a damaged one, makes NumPy raise; ValueError also says that it holds a pickle."""

_RECORDED = "a trajectory.npz of contarm run"


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
            InputError: not such a file, or one whose numbers are not finite; pressures may be inf, as said above.
        """
        try:
            with Path(path).open("rb") as file, np.load(file, allow_pickle=False) as stored:
                arrays = {item.name: np.asarray(stored[item.name]) for item in fields(cls) if item.name in stored}
        except _BROKEN as error:
            said = " ".join(str(error).split()) or type(error).__name__
            raise InputError("file", f"unreadable ({said})", _RECORDED, str(path)) from error
        for item in fields(cls):
            if item.name not in arrays:
                raise InputError("file", f"one without the array {item.name!r}", _RECORDED, str(path))
            _refuse_bad_numbers(item.name, arrays[item.name], str(path))
        return cls(**arrays)


def _refuse_bad_numbers(name: str, array: Array, where: str) -> None:
    if array.dtype.kind not in "fiu":
        raise InputError(name, f"an array of {array.dtype}", "an array of real numbers", where)
    bad = np.isnan(array) | (array == -np.inf) if name == "pressure" else ~np.isfinite(array)
    if bad.any():
        place = np.argwhere(bad)[0]
        value, sample = array[tuple(place)], f" in sample {place[0]}" if len(place) else ""
        raise InputError(name, f"{value}{sample}", "finite numbers" + (", or inf" if name == "pressure" else ""), where)

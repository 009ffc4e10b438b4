"""Trajectories on disk: one compressed .npz of arrays, and what they are a result of as JSON."""

from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm_file import arm_from_dict, arm_to_dict
from contarm_sim.results.trajectory import ARRAYS, STATUSES, Trajectory

_BROKEN = (OSError, EOFError, ValueError, TypeError, RuntimeError, MemoryError, BadZipFile, zlib.error, struct.error)
"""What a file that is no .npz, or a damaged one, makes NumPy raise; ValueError also says that it holds a pickle."""

_RECORDED = "a trajectory.npz of contarm run"

_ABOUT = (
    "controller", "actuation", "pulls_only", "holds_lengths", "status", "timestep", "extrapolated", "real_time_factor",
    "versions",
)  # fmt: skip


def write(trajectory: Trajectory, path: Path) -> None:
    """Write a trajectory."""
    about = {name: getattr(trajectory, name) for name in _ABOUT} | {"arm": arm_to_dict(trajectory.arm)}
    arrays = {name: getattr(trajectory, name) for name in ARRAYS}
    if trajectory.step_error is not None:
        arrays["step_error"] = trajectory.step_error
    np.savez_compressed(path, about=np.array(json.dumps(about)), **arrays)


def read(path: Path) -> Trajectory:
    """Return a trajectory that `write` wrote.

    Raises:
        InputError: not such a file, or arrays that do not fit together or hold what is not a number.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            about = json.loads(str(stored["about"])) if "about" in stored else None
            arrays: dict[str, Any] = {
                name: np.asarray(stored[name]) for name in (*ARRAYS, "step_error") if name in stored
            }
    except _BROKEN as error:
        said = " ".join(str(error).split()) or type(error).__name__
        raise InputError("file", f"unreadable ({said})", _RECORDED, str(path)) from error
    for name in ARRAYS:
        if name not in arrays:
            raise InputError("file", f"one without the array {name!r}", _RECORDED, str(path))
        _refuse_bad_numbers(name, arrays[name], str(path))
    arm, given = _about(about, str(path))
    _refuse_bad_shapes(arrays, arm, str(path))
    return Trajectory(arm=arm, **given, **arrays)


def _about(about: Any, where: str) -> tuple[Any, dict[str, Any]]:
    if not isinstance(about, dict) or not isinstance(about.get("arm"), dict):
        raise InputError("file", "one that does not say which arm it is of", _RECORDED, where)
    given = {name: about[name] for name in _ABOUT if name in about}
    if given.get("status") not in STATUSES or not isinstance(given.get("controller"), str):
        raise InputError("about", "without status or controller", _RECORDED, where)
    return arm_from_dict(about["arm"], where), given


def _refuse_bad_shapes(arrays: dict[str, Array], arm: Any, where: str) -> None:
    count = len(arrays["time"]) if arrays["time"].ndim == 1 else -1
    muscles = arrays["setpoint"].shape[-1] if arrays["setpoint"].ndim == 2 else 3
    shapes = {
        "time": (count,), "target": (count, 3), "bend": (count, 2), "setpoint": (count, muscles),
        "muscle_lengths": (count, muscles), "muscle_tensions": (count, muscles), "pressure": (count, muscles),
        "stations": (count, arm.links + 1, 3), "tip_rotation": (count, 3, 3),
        "qpos": (count, arm.links * (2 if arm.torsional_stiffness is None else 3)), "step_error": (count,),
    }  # fmt: skip
    for name, array in arrays.items():
        if array.shape != shapes[name]:
            raise InputError(name, f"of shape {array.shape}", f"shape {shapes[name]}", where)


def _refuse_bad_numbers(name: str, array: Array, where: str) -> None:
    if array.dtype.kind not in "fiu":
        raise InputError(name, f"an array of {array.dtype}", "an array of real numbers", where)
    bad = np.isnan(array) | (array == -np.inf) if name == "pressure" else ~np.isfinite(array)
    if bad.any():
        place = np.argwhere(bad)[0]
        value, sample = array[tuple(place)], f" in sample {place[0]}" if len(place) else ""
        raise InputError(name, f"{value}{sample}", "finite numbers" + (", or inf" if name == "pressure" else ""), where)

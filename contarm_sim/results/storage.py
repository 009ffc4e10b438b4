"""Trajectories on disk: one compressed .npz of arrays, and what they are a result of as JSON."""

from __future__ import annotations

import errno
import json
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.inputs import as_path, quoted
from contarm_sim.mechanics.contacts import SHAPES as CONTACTS
from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_from_dict, arm_to_dict
from contarm_sim.results.arrays import RECORDING, SHAPES, read_arrays, require_arms_own
from contarm_sim.results.trajectory import ARRAYS, OPTIONAL, STATUSES, Trajectory

CONTACT = "contact_"
"""What the names of the columns of contacts begin with."""

_KINDS: dict[str, Any] = {
    "controller": str, "actuation": str, "pulls_only": bool, "holds_lengths": bool, "status": str,
    "timestep": (float, int, NoneType), "extrapolated": bool, "real_time_factor": (float, int, NoneType),
    "versions": dict,
}  # fmt: skip
"""What a trajectory says of itself beside its arm and its arrays."""


def write(trajectory: Trajectory, given: str | Path) -> None:
    """Write a trajectory.

    Raises:
        InputError: a name that does not end in .npz, a folder that is not there, or a disk that does not take it.
    """
    path = as_path("path", given, "a name that ends in .npz")
    if path.suffix.lower() != ".npz":
        raise InputError("path", quoted(path), "a name that ends in .npz")
    about = {name: getattr(trajectory, name) for name in _KINDS} | {"arm": arm_to_dict(trajectory.arm)}
    arrays = {name: getattr(trajectory, name) for name in (*ARRAYS, *OPTIONAL)}
    arrays = {name: array for name, array in arrays.items() if array is not None}
    if trajectory.contacts is not None:
        arrays |= {CONTACT + name: getattr(trajectory.contacts, name) for name in CONTACTS}
    try:
        with path.open("wb") as file:
            np.savez_compressed(file, about=np.array(json.dumps(about)), **arrays)
    except OSError as error:
        if error.errno == errno.ENOSPC:
            raise
        raise InputError("path", f"{quoted(path)} ({error.strerror})", "a file that can be written") from error


def read(given: str | Path) -> Trajectory:
    """Return a trajectory that `write` wrote.

    Raises:
        InputError: not such a file, or arrays that do not fit together or hold what is not a number.
    """
    path = as_path("path", given, RECORDING)
    touched = {CONTACT + name: shape for name, shape in CONTACTS.items()}
    arrays, text = read_arrays(path, SHAPES | touched, optional=(*OPTIONAL, *touched))
    arm, told = _about(text, str(path))
    columns: dict[str, Any] = {name: arrays.pop(CONTACT + name) for name in CONTACTS if CONTACT + name in arrays}
    require_arms_own(arm, arrays, str(path))
    try:
        contacts = Contacts(**columns, names=arm.world.partners) if len(columns) == len(CONTACTS) else None
        return Trajectory(arm=arm, contacts=contacts, **(told | arrays))
    except InputError as error:
        raise error.located(error.where or str(path)) from None


def _about(text: str | None, where: str) -> tuple[Arm, dict[str, Any]]:
    try:
        about = json.loads(text or "null")
    except (ValueError, RecursionError):
        about = None
    if not isinstance(about, dict) or not isinstance(about.get("arm"), dict):
        raise InputError("file", "one that does not say which arm it is of", RECORDING, where)
    given = {name: about[name] for name in _KINDS if name in about}
    for name, value in given.items():
        if not isinstance(value, _KINDS[name]) or (name == "status" and value not in STATUSES):
            raise InputError(f"about.{name}", value, RECORDING, where)
    for name in ("status", "controller"):
        if name not in given:
            raise InputError("about", f"without {name}", RECORDING, where)
    return arm_from_dict(about["arm"], where), given

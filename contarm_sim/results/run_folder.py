"""What `contarm run` left, opened again."""

from __future__ import annotations

import os
from pathlib import Path

from contarm_sim.errors import InputError
from contarm_sim.model.arm_file import load_arm
from contarm_sim.results.trajectory import Trajectory

NUMBERS = ("trajectory.npz", "arm.toml")
"""The files that make a run's folder."""


def load(path: str | Path) -> Trajectory:
    """Return the trajectory of a folder that `contarm run` or `Trajectory.report` left, or of a .npz file.

    Raises:
        InputError: neither of the two, a damaged one, or a folder whose arm.toml is of another arm; names the file.
    """
    allowed = f"a folder that contarm run left, with {' and '.join(NUMBERS)}, or a .npz that Trajectory.save wrote"
    if not isinstance(path, (str, os.PathLike)):
        raise InputError("path", path, allowed)
    place = Path(path)
    try:
        is_folder, is_file = place.is_dir(), place.is_file()
    except (OSError, ValueError):  # a name too long, or with a null character
        is_folder = is_file = False
    if is_file:
        return Trajectory.load(place)
    if not is_folder:
        raise InputError("path", repr(str(path)), allowed)
    try:
        return load_folder(place)
    except InputError as error:
        if error.name != "run_dir":
            raise
        raise InputError("path", error.given, allowed) from None


def load_folder(folder: Path) -> Trajectory:
    """Return the trajectory of a folder that `contarm run` left.

    Raises:
        InputError: as `load`.
    """
    if not all(os.path.isfile(folder / name) for name in NUMBERS):
        allowed = f"a folder that contarm run left, with {' and '.join(NUMBERS)}"
        raise InputError("run_dir", str(folder), allowed)
    arm, samples = load_arm(folder / "arm.toml"), Trajectory.load(folder / "trajectory.npz")
    if samples.arm != arm:
        allowed = "the arm that was recorded"
        raise InputError("arm.toml", "another arm than that of trajectory.npz", allowed, str(folder))
    return samples

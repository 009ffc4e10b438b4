"""What `contarm run` left, opened again."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from contarm_sim.errors import InputError
from contarm_sim.inputs import as_path, quoted
from contarm_sim.model.arm_file import arm_to_dict, load_arm
from contarm_sim.results.trajectory import Trajectory

NUMBERS = ("trajectory.npz", "arm.toml")
"""The files that make a run's folder."""

_FOLDER = f"a folder that contarm run left, with {' and '.join(NUMBERS)}"

_BESIDE = ("summary.json", "samples.csv", "contacts.csv", "report.html", "arm.xml", *NUMBERS)
"""Files of a run's folder that somebody may give in its place."""


def load(path: str | Path) -> Trajectory:
    """Return the trajectory of a folder that `contarm run` or `Trajectory.report` left, or of a .npz file.

    Raises:
        InputError: neither of the two, a damaged one, or a folder whose arm.toml is of another arm; names the file.
    """
    allowed = f"{_FOLDER}, or a .npz that Trajectory.save wrote"
    place = as_path("path", path, allowed)
    try:
        is_folder, is_file = place.is_dir(), place.is_file()
    except (OSError, ValueError):  # a name too long, or with a null character
        is_folder = is_file = False
    if is_file and place.suffix.lower() != ".npz" and place.name in _BESIDE:
        raise InputError("path", quoted(place), f"the folder that it is in, {quoted(place.parent)}, or its .npz")
    if is_file:
        return Trajectory.load(place)
    if not is_folder:
        raise InputError("path", quoted(place), allowed)
    return load_folder(place, "path", allowed)


def load_folder(folder: Path, name: str = "run_dir", allowed: str = _FOLDER) -> Trajectory:
    """Return the trajectory of a folder that `contarm run` left; meshes of its arm are the copies in it.

    Args:
        name: of what was given, for the message.
        allowed: what may be given, for the message.

    Raises:
        InputError: as `load`.
    """
    missing = [each for each in NUMBERS if not os.path.isfile(folder / each)]
    if missing:
        without = f", which has no {missing[0]}" if len(missing) < len(NUMBERS) else ""
        raise InputError(name, f"{quoted(folder)}{without}", allowed)
    arm, samples = load_arm(folder / "arm.toml"), Trajectory.load(folder / "trajectory.npz")
    if samples.arm == arm:
        return samples
    if arm_to_dict(samples.arm, beside=True) != arm_to_dict(arm, beside=True):
        recorded = "the arm that was recorded"
        raise InputError("arm.toml", "another arm than that of trajectory.npz", recorded, str(folder))
    return replace(samples, arm=arm)

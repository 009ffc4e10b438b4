"""Recordings written to a folder: recording.csv and the recording.toml that describes it, in SI units."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.files import write_whole
from contarm_sim.identify.recordings.recording import OTHERS, Recording
from contarm_sim.identify.recordings.rig_file import rig_tables, toml_text
from contarm_sim.inputs import as_path
from contarm_sim.kinematics.arrays import Array

TABLE, NOTE = "recording.csv", "recording.toml"
"""Names of the files of a recording in its folder."""


def save_recording(recording: Recording, folder: str | Path) -> Path:
    """Write a recording into a folder, which is made; `load_recording` reads the same numbers back.

    Returns:
        the TOML file.

    Raises:
        InputError: the folder cannot be written to.
    """
    target = as_path("folder", folder, "a folder to write to")
    names, columns = _columns(recording)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["block", *names])
    for block, row in zip(recording.blocks.tolist(), columns.tolist(), strict=True):
        writer.writerow([block, *("" if math.isnan(x) else repr(x) for x in row)])
    try:
        target.mkdir(parents=True, exist_ok=True)
        write_whole(target / TABLE, text.getvalue())
        write_whole(target / NOTE, toml_text(_spec(recording)))
    except OSError as error:
        raise InputError("folder", f"not written ({error.strerror})", "a folder to write to", str(target)) from None
    return target / NOTE


def _columns(recording: Recording) -> tuple[list[str], Array]:
    names, parts = ["time"], [recording.time[:, None], recording.commands]
    names += [f"command_{k + 1}" for k in range(recording.commands.shape[1])]
    for number in range(len(recording.rig.markers)):
        names += _axes(f"marker_{number + 1}")
        parts.append(recording.positions[:, number])
    if recording.payload is not None:
        names.append("payload")
        parts.append(recording.payload[:, None])
    if recording.force is not None:
        names += _axes("force")
        parts.append(recording.force)
    return names, np.concatenate(parts, axis=1)


def _axes(name: str) -> list[str]:
    return [f"{name}_{axis}" for axis in "xyz"]


def _spec(recording: Recording) -> dict[str, Any]:
    rig = rig_tables(recording.rig)
    commands: dict[str, Any] = {"drive": recording.rig.actuation.drive}
    if recording.commands.shape[1]:
        names = [f"command_{k + 1}" for k in range(recording.commands.shape[1])]
        commands = {**rig["actuation"], "columns": names, "unit": "SI"}
    spec: dict[str, Any] = {
        "name": recording.name,
        "kind": recording.kind,
        "data": TABLE,
        "block": "block",
        "time": {"column": "time", "unit": "s", "origin": 0.0},
        "frame": rig["frame"],
        "commands": commands,
    }
    if recording.kind == "motion":
        spec |= {name: getattr(recording, name) for name in OTHERS}
    if recording.payload is not None:
        spec["payload"] = {"column": "payload", "unit": "kg"}
    if recording.force is not None:
        spec["force"] = {"columns": _axes("force"), "unit": "N", "xi": recording.force_xi}
    spec["markers"] = [
        {**marker, "columns": _axes(f"marker_{number + 1}"), "unit": "m"}
        for number, marker in enumerate(rig["markers"])
    ]
    return spec

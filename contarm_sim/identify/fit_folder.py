"""A fit in a folder: the arm and the rigs that it found, tables to look at, and all of it to be read back.

arm.toml          the fitted arm; comments say what was not determined
rig.toml          the fitted rig; of several recordings rig_2.toml, ... beside it
parameters.csv    what became of the free parameters, SI units
residuals.csv     each marker at each sample: measured, predicted and error [m], and whether it was held out
fit.npz           the whole fit; `load_fit` reads it with the arm and the rigs
"""

from __future__ import annotations

import csv
import io
import json
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.files import appearing, write_whole
from contarm_sim.identify.fitted import FOUND, Combination, Fit, Left, Parameter
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig_file import load_rig, save_rig
from contarm_sim.inputs import as_path, quoted
from contarm_sim.model.arm_file import arm_to_toml, load_arm

ARM, ALL = "arm.toml", "fit.npz"
"""Files that make a fit's folder; and its rigs."""

_ARRAYS = ("correlation", "singular_values")
_TOLD = ("noise", "cost", "converged", "evaluations", "seconds", "method", "message")


def save_fit(fit: Fit, folder: str | Path) -> Path:
    """Write a fit into a folder, which is made; see the module.

    Returns:
        the folder.

    Raises:
        InputError: the folder cannot be written to.
    """
    target = as_path("folder", folder, "a folder to write to")
    try:
        target.mkdir(parents=True, exist_ok=True)
        write_whole(target / ARM, _arm_text(fit))
        for number, rig in enumerate(fit.rigs):
            save_rig(rig, target / rig_name(number))
        write_whole(target / "parameters.csv", _table(_PARAMETERS, map(_row, fit.parameters)))
        write_whole(target / "residuals.csv", _table(_RESIDUALS, _residuals(fit.left)))
        with appearing(target / ALL) as scratch, scratch.open("wb") as file:
            np.savez_compressed(file, **_arrays(fit))
    except OSError as error:
        raise InputError("folder", f"not written ({error.strerror})", "a folder to write to", str(target)) from None
    return target


def rig_name(number: int) -> str:
    """Return the file of the rig of a recording, numbered from 0."""
    return "rig.toml" if number == 0 else f"rig_{number + 1}.toml"


def _arm_text(fit: Fit) -> str:
    found = [one.name for one in fit.parameters if one.status in FOUND]
    kept = [one for one in fit.parameters if one.status not in FOUND]
    names = ", ".join(one.recording.name for one in fit.left)
    lines = [f"# Fitted to {names}: {', '.join(found) if found else 'nothing was determined'}."]
    if any(one.status == "only with others" for one in kept):
        lines.append("# Of what is determined only with others, the values are one of many sets that fit.")
    if not fit.converged:
        lines.insert(0, f"# Not finished: {fit.message}. Values are those that the search had come to.")
    for one in kept:
        why = f": {one.said}" if one.said else ""
        lines.append(f"# Not determined ({one.status}): {one.name}{why}.")
    return "\n".join(" ".join(line.split()) for line in lines) + "\n\n" + arm_to_toml(fit.arm)


_PARAMETERS = (
    "name", "unit", "start", "value", "sd", "low", "high", "boot_low", "boot_high", "status", "said", "lower_bound",
    "upper_bound", "prior_mean", "prior_sd",
)  # fmt: skip
_RESIDUALS = (
    "recording", "sample", "time_s", "block", "marker", "x_m", "y_m", "z_m", "predicted_x_m", "predicted_y_m",
    "predicted_z_m", "error_x_m", "error_y_m", "error_z_m", "distance_m", "held_out",
)  # fmt: skip


def _row(one: Parameter) -> list[Any]:
    free = one.free
    return [one.name, *(getattr(one, name) for name in _PARAMETERS[1:11]), free.low, free.high, free.mean, free.sd]


def _residuals(left: Sequence[Left]) -> Iterator[list[Any]]:
    for one in left:
        recording, error = one.recording, one.error
        distance = np.sqrt((error**2).sum(axis=-1))
        for row in range(len(recording)):
            told = [recording.name, row, float(recording.time[row]), str(recording.blocks[row])]
            for place, marker in enumerate(recording.rig.markers):
                numbers = [*recording.positions[row, place], *one.predicted[row, place], *error[row, place]]
                values = [float(x) for x in (*numbers, distance[row, place])]
                yield [*told, marker.name, *values, int(one.held_out[row])]


def _table(names: Sequence[str], rows: Any) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    for row in rows:
        writer.writerow(["" if x is None or x != x else repr(x) if isinstance(x, float) else x for x in row])
    return text.getvalue()


def _arrays(fit: Fit) -> dict[str, Any]:
    out: dict[str, Any] = {name: getattr(fit, name) for name in _ARRAYS}
    recordings = []
    for number, one in enumerate(fit.left):
        told = {}
        for item in fields(Recording):
            value = getattr(one.recording, item.name)
            if isinstance(value, np.ndarray):
                out[f"{number}.{item.name}"] = value
            elif item.name != "rig":
                told[item.name] = value
        out |= {f"{number}.predicted": one.predicted, f"{number}.held_out": one.held_out}
        recordings.append(told)
    about = {name: getattr(fit, name) for name in _TOLD} | {
        "parameters": [asdict(one) for one in fit.parameters],
        "undetermined": [asdict(one) for one in fit.undetermined],
        "recordings": recordings,
    }
    return out | {"about": np.array(json.dumps(about))}


def load_fit(folder: str | Path) -> Fit:
    """Return the fit of a folder that `save_fit` wrote.

    Raises:
        InputError: not such a folder, or a damaged file; names it.
    """
    allowed = f"a folder that contarm fit left, with {ARM} and {ALL}"
    place = as_path("folder", folder, allowed)
    for name in (ARM, ALL):
        if not (place / name).is_file():
            raise InputError("folder", f"{quoted(place)}, which has no {name}", allowed)
    try:
        with ZipFile(place / ALL) as archive:
            arrays = {name.removesuffix(".npy"): _array(archive, name) for name in archive.namelist()}
        about = json.loads(str(arrays.pop("about")))
        return _fit_of(about, arrays, place)
    except (OSError, ValueError, KeyError, TypeError, EOFError, BadZipFile, zlib.error) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("file", f"damaged ({type(error).__name__})", "a file that save_fit wrote",
                         str(place / ALL)) from error  # fmt: skip


def _array(archive: ZipFile, name: str) -> Any:
    with archive.open(name) as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def _fit_of(about: dict[str, Any], arrays: dict[str, Any], place: Path) -> Fit:
    left, rigs = [], []
    for number, told in enumerate(about.pop("recordings")):
        own = {name.partition(".")[2]: array for name, array in arrays.items() if name.startswith(f"{number}.")}
        predicted, held_out = own.pop("predicted"), own.pop("held_out")
        rigs.append(load_rig(place / rig_name(number)))
        left.append(Left(Recording(**told, **own, rig=rigs[-1]), predicted, held_out))
    parameters = tuple(Parameter(**(one | {"free": Free(**one["free"])})) for one in about.pop("parameters"))
    undetermined = tuple(
        Combination(**(one | {name: tuple(one[name]) for name in ("names", "weights")}))
        for one in about.pop("undetermined")
    )
    return Fit(
        arm=load_arm(place / ARM), rigs=tuple(rigs), parameters=parameters, undetermined=undetermined,
        left=tuple(left), **{name: arrays[name] for name in _ARRAYS}, **(about | {"cost": tuple(about["cost"])}),
    )  # fmt: skip

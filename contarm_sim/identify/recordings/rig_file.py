"""Rigs as TOML, so that one that was fitted to a recording can stand around the arm in another: SI units.

[frame] is where the arm's base stands in the frame of the measurements, [[markers]] what is tracked, [actuation] what
the channels drive; channels are counted from 1, as names of parameters are.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError, one_line
from contarm_sim.files import write_whole
from contarm_sim.identify.recordings.keys import PLACES, gravity_of, numbers, place_of, quaternion_of, table
from contarm_sim.identify.recordings.rig import Actuation, Marker, Rig
from contarm_sim.inputs import as_path, read_text
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_table import refuse_unknown

MOST_BYTES = 2**20
"""Largest TOML file that is read [bytes]."""

_FRAME = ("position", "orientation", "turn", "gravity")
_DRIVEN = {"windings": "m", "tensions": "N", "pressures": "Pa", "none": "-"}


def read_toml(path: Path, line: str) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Args:
        line: that could stand there, for the message.

    Raises:
        InputError: it cannot be read, or is no TOML.
    """
    text = read_text(path, "a TOML file", MOST_BYTES)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        given = f"not TOML ({one_line(str(error), 80)})"
        raise InputError("file", given, f"lines such as: {line}", str(path)) from None


def toml_text(values: dict[str, Any]) -> str:
    """Return values as TOML, lists of numbers and texts on one line."""
    import tomli_w

    rows = tomli_w.dumps(values)
    return re.sub(r"\[\n([^\[\]]*?),\n\]", lambda found: f"[{' '.join(found[1].split())}]", rows)


def frame_of(values: Any, name: str = "frame") -> dict[str, Any]:
    """Return the arguments of `Rig` that a table [frame] says; its axes make the orientation.

    Raises:
        InputError: unknown keys, values of another kind, or an orientation that is said twice.
    """
    given = table(values, name, [*_FRAME, "z", "x"])
    found: dict[str, Any] = {}
    if "position" in given:
        found["position"] = numbers(given["position"], "m", f"{name}.position", 3)
    if "turn" in given:
        found["turn"] = numbers(given["turn"], "rad", f"{name}.turn", 3)
    if "gravity" in given:
        found["gravity"] = gravity_of(given["gravity"], f"{name}.gravity")
    if "orientation" in given:
        if "z" in given or "x" in given:
            raise InputError(f"{name}.orientation", "said by axes too", "a quaternion w x y z, or z and x")
        found["orientation"] = numbers(given["orientation"], "-", f"{name}.orientation", 4)
    elif "z" in given or "x" in given:
        found["orientation"] = quaternion_of(given.get("z", "z"), given.get("x"), name)
    return found


def marker_of(values: dict[str, Any], number: int, arm: Arm | None = None) -> Marker:
    """Return a marker of a table [[markers]]: `name`, its place, `offset` [m].

    Raises:
        InputError: a place off the arm, or no offset.
    """
    usual = "tip" if "name" not in values and place_of(values, "marker", arm) == 1 else f"marker {number}"
    name = values.get("name", usual)
    if not isinstance(name, str) or not name.strip():
        raise InputError(f"marker {number}.name", name, "a text")
    where = f"marker {name}"
    offset = numbers(values.get("offset", [0.0, 0.0, 0.0]), "m", f"{where}.offset", 3)
    return Marker(name=name, xi=place_of(values, where, arm), offset=offset)  # type: ignore[arg-type]


def load_rig(path: str | Path, arm: Arm | None = None) -> Rig:
    """Read a rig from TOML: tables [frame], [[markers]] and [actuation], see `save_rig`.

    Args:
        arm: needed where a marker's place is said by station, place [m] or section_end.

    Raises:
        InputError: the file cannot be read, or holds an unknown key or a bad value.
    """
    file = as_path("rig", path, "a TOML file")
    values = read_toml(file, "[frame], position = [0, 0, 0]")
    try:
        return _rig_of(values, arm)
    except InputError as error:
        raise error.located(error.where or str(file)) from None


def _rig_of(values: dict[str, Any], arm: Arm | None) -> Rig:
    own = [item.name for item in fields(Rig) if item.name not in (*_FRAME, "markers", "actuation")]
    refuse_unknown(values, ["frame", "markers", "actuation", *own])
    found: dict[str, Any] = {
        **frame_of(values.get("frame", {})),
        **{name: values[name] for name in own if name in values},
    }
    if "markers" in values:
        if not isinstance(values["markers"], list):
            raise InputError("markers", values["markers"], "tables, [[markers]]")
        known = list(dict.fromkeys([*(item.name for item in fields(Marker)), *PLACES]))
        tables = [table(one, f"marker {k + 1}", known) for k, one in enumerate(values["markers"])]
        found["markers"] = tuple(marker_of(one, k + 1, arm) for k, one in enumerate(tables))
    if "actuation" in values:
        given = dict(table(values["actuation"], "actuation", [item.name for item in fields(Actuation)]))
        channels = [given.pop("channels")] if isinstance(given.get("channels"), int) else given.pop("channels", [])
        if not all(isinstance(one, int) and one >= 1 for one in channels):
            raise InputError("actuation.channels", channels, "whole numbers from 1")
        unit = _DRIVEN.get(given.get("drive", "windings"), "-")
        if "slack" in given:
            given["slack"] = numbers(given["slack"], unit, "actuation.slack", len(channels))
        given = {name: tuple(x) if isinstance(x, list) else x for name, x in given.items()}
        found["actuation"] = Actuation(channels=tuple(one - 1 for one in channels), **given)
    return Rig(**found)


def save_rig(rig: Rig, path: str | Path) -> Path:
    """Write a rig as TOML; `load_rig` reads it back to an equal one.

    Raises:
        InputError: the file cannot be written.
    """
    file = as_path("rig", path, "a TOML file to write")
    try:
        write_whole(file, toml_text(rig_tables(rig)))
    except OSError as error:
        raise InputError(
            "rig", f"not written ({error.strerror})", "a folder that can be written to", str(file)
        ) from None
    return file


def rig_tables(rig: Rig) -> dict[str, Any]:
    """Return a rig as the tables of its TOML, all in SI units."""
    own = {item.name: getattr(rig, item.name) for item in fields(rig) if item.name not in ("markers", "actuation")}
    actuation = {item.name: _plain(getattr(rig.actuation, item.name)) for item in fields(rig.actuation)}
    actuation["channels"] = [one + 1 for one in rig.actuation.channels]
    frame = {name: _plain(own.pop(name)) for name in _FRAME if own[name] is not None}
    own.pop("gravity", None)
    return {
        **{name: _plain(x) for name, x in own.items() if x is not None},
        "frame": frame,
        "markers": [{item.name: _plain(getattr(one, item.name)) for item in fields(one)} for one in rig.markers],
        "actuation": {name: x for name, x in actuation.items() if x is not None},
    }


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value

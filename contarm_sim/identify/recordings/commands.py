"""The table [commands] of a recording: which columns command which muscles, in which units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.errors import InputError, did_you_mean
from contarm_sim.identify.recordings.columns import Columns
from contarm_sim.identify.recordings.keys import choice, in_si, numbers, table
from contarm_sim.identify.recordings.rig import DRIVES, Actuation
from contarm_sim.identify.recordings.updates import BETWEEN, drawn_through
from contarm_sim.kinematics.arrays import Array

_KEYS = ("drive", "columns", "unit", "pull", "channels", "signs", "gains", "pulley_radius", "slack",
         "between_updates")  # fmt: skip
_UNITS = {"windings": ("m", "rad", "-"), "tensions": ("N", "rad", "-"), "pressures": ("Pa", "-")}


@dataclass(frozen=True, eq=False)
class Commanded:
    """Commands of C channels in T rows, shape (T, C), NaN where one is missing, and what they drive."""

    values: Array
    actuation: Actuation


def commanded(
    columns: Columns, given: Any, gaps: Sequence[Any], time: Array, blocks: Sequence[str]
) -> Commanded:  # fmt: skip
    """Return what a table [commands] says; without one, or with drive "none", nothing is driven.

    Args:
        columns: of T rows.
        given: the table.
        gaps: what says that a number is missing.
        time, blocks: of the rows.

    Raises:
        InputError: unknown keys, columns that are missing, a unit of another kind, or lists that do not fit together.
    """
    given = table({"drive": "none"} if given is None else given, "commands", _KEYS)
    drive: Any = choice(given.get("drive"), "commands.drive", DRIVES)
    if drive == "none":
        if len(given) > 1:
            raise InputError("commands", f"drive none with {', '.join(list(given)[1:])}", "drive alone")
        return Commanded(np.empty((len(columns), 0)), Actuation(drive="none"))
    names = columns.named(given.get("columns", "missing"), "commands.columns")
    raw = np.stack([columns.numbers(name, "commands.columns", gaps) for name in names], axis=1)
    if (
        isinstance(given.get("unit"), str) and given["unit"] == "SI"
    ):  # as `save_recording` writes: whatever it was, it is so already
        values, unit = raw, ""
    else:
        values, unit = in_si(raw, given.get("unit"), _UNITS[drive], "commands.unit")
    pull = choice(given.get("pull", "positive"), "commands.pull", ["positive", "negative"])
    if choice(given.get("between_updates", "held"), "commands.between_updates", BETWEEN) == "linear":
        values = drawn_through(values, time, blocks)
    channels = _channels(given.get("channels", list(range(1, len(names) + 1))), names)
    actuation = Actuation(
        drive=drive,
        channels=channels,
        signs=numbers(given.get("signs", 1.0), "-", "commands.signs", len(channels)),
        gains=_gains(given, drive, unit, len(names)),
        slack=numbers(given.get("slack", 0.0), _UNITS[drive][0], "commands.slack", len(channels)),
    )
    return Commanded(0.0 - values if pull == "negative" else values, actuation)


def _channels(given: Any, names: list[str]) -> tuple[int, ...]:
    """Return the channel of each muscle, from 0, of numbers from 1 or names of columns."""
    if not isinstance(given, list) or not given:
        raise InputError("commands.channels", given, "for each muscle the number, from 1, or the name of its column")
    found = []
    for one in given:
        if isinstance(one, str):
            if one not in names:
                allowed = f"{did_you_mean(one, names)}one of {', '.join(names)}"
                raise InputError("commands.channels", repr(one), allowed)
            found.append(names.index(one))
        elif isinstance(one, bool) or not isinstance(one, int) or not 1 <= one <= len(names):
            raise InputError("commands.channels", one, f"numbers from 1 to {len(names)}, as there are columns")
        else:
            found.append(one - 1)
    return tuple(found)


def _gains(given: dict[str, Any], drive: str, unit: str, count: int) -> tuple[float, ...]:
    """Return what one unit of each channel is worth; angles need the radius of their pulleys, other units a gain."""
    if "pulley_radius" in given:
        if "gains" in given or drive != "windings" or unit != "rad":
            allowed = "of windings in rad or deg, without gains"
            raise InputError("commands.pulley_radius", given["pulley_radius"], allowed)
        return numbers(given["pulley_radius"], "m", "commands.pulley_radius", count)
    if "gains" in given:
        return numbers(given["gains"], "-", "commands.gains", count)
    if unit == "rad" and drive == "windings":
        raise InputError("commands.pulley_radius", "missing", "the radius of each pulley [m], or one for all")
    if unit in ("rad", "-"):
        allowed = f"what one unit of each channel is worth [{_UNITS[drive][0]}], or one for all"
        raise InputError("commands.gains", "missing", allowed)
    return (1.0,) * count

"""Paths from a CSV file of tip positions."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.inputs import read_text
from contarm_sim.kinematics.arrays import Array, sinc
from contarm_sim.paths import Path as TipPath
from contarm_sim.paths import require_duration
from contarm_sim.paths.table import read_table

UNITS = {"t": "s", "x": "m", "y": "m", "z": "m"}
"""Columns of a file of tip positions, and their SI units."""


@dataclass(frozen=True)
class Waypoints:
    """Tip positions from a file.

    Attributes:
        positions: [m], shape (T, 3).
        times: [s], shape (T,), or None where the file has no column of times.
        places: file and row of each, for messages.
        notes: what was converted, and which columns were not read, for people.
    """

    positions: Array
    times: Array | None
    places: list[str]
    notes: tuple[str, ...] = ()


def read_csv(file: str | Path) -> Waypoints:
    """Read tip positions from a CSV file with the columns `x,y,z` and perhaps `t` (or `time`), in m and s.

    A header may give other units, `x [mm]`; without a header, three columns are x,y,z and four t,x,y,z. Semicolons or
    tabs may stand between the columns, and then commas for decimal points.

    Raises:
        InputError: unreadable, empty, a missing column, or a bad cell, with its row and column.
    """
    where = str(file)
    text = read_text(file, "a CSV file with columns x,y,z or t,x,y,z")
    table = read_table(text, UNITS, {"time": "t"}, ("t", "x", "y", "z"), where)
    missing = [name for name in "xyz" if name not in table.columns]
    if missing:
        found = ",".join(table.columns) or "no known column"
        allowed = f"columns x,y,z or t,x,y,z, also with units, x [mm] (missing: {', '.join(missing)})"
        raise InputError("header", repr(found), allowed, where)
    if not table.rows:
        raise InputError("file", "without rows below its header", "at least one row of x,y,z", where)
    positions = np.column_stack([table.columns[name] for name in "xyz"])
    times = table.columns.get("t")
    if times is not None and np.any(np.diff(times) <= 0):
        bad = int(np.argmax(np.diff(times) <= 0)) + 1
        allowed = f"more than the row before ({times[bad - 1]:g} s)"
        raise InputError(f"t in row {table.rows[bad]}", float(times[bad]), allowed, where)
    places = [f"{where}, row {number}" for number in table.rows]
    return Waypoints(positions, times, places, tuple(f"{where}: {note}" for note in table.notes))


def from_waypoints(waypoints: Waypoints, length: float, duration: float | None = None, on_dome: bool = True) -> TipPath:
    """Return a smooth path through waypoints.

    Interpolates direction and distance relative to the dome with monotone cubics, so that between waypoints on
    the dome the path stays on it.

    Args:
        on_dome: False: interpolate positions as they are, for tips that reach more than the dome.
        duration: [s]; default what the waypoints' times span, or 10 without times (then at even speed).

    Raises:
        InputError: fewer than two waypoints, or a duration that is not positive.
    """
    from scipy.interpolate import PchipInterpolator

    positions, times = waypoints.positions, waypoints.times
    if len(positions) < 2:
        raise InputError("waypoints", len(positions), "at least two rows")
    shaped = _on_dome(positions, length) if on_dome else positions
    steps = np.diff(times) if times is not None else np.linalg.norm(np.diff(positions, axis=0), axis=1)
    if np.any(steps <= 0):
        bad = int(np.argmax(steps <= 0)) + 2
        raise InputError(
            "x,y,z", positions[bad - 1].tolist(), "a position other than the one before", waypoints.places[bad - 1]
        )
    knots = np.concatenate([[0.0], np.cumsum(steps)])
    smooth = PchipInterpolator(knots / knots[-1], shaped)

    def curve(s: Array) -> Array:
        value = np.asarray(smooth(s), dtype=float)
        if not on_dome:
            return value
        half = np.hypot(value[:, 0], value[:, 1])
        distance = value[:, 2] * length * sinc(half)
        return distance[:, None] * np.column_stack([sinc(half)[:, None] * value[:, :2], np.cos(half)])

    total = duration if duration is not None else (knots[-1] if times is not None else 10.0)
    require_duration(total)
    return TipPath("waypoints", curve, total, even=times is None)


def _on_dome(positions: Array, length: float) -> Array:
    """Return half the bends towards positions, and their distances by those of the dome there, shape (T, 3)."""
    rho = np.hypot(positions[:, 0], positions[:, 1])
    half = np.arctan2(rho, positions[:, 2])
    lateral = positions[:, :2] * np.divide(half, rho, out=np.zeros_like(rho), where=rho != 0)[:, None]
    ratio = np.hypot(rho, positions[:, 2]) / (length * sinc(half))
    return np.column_stack([lateral, ratio])

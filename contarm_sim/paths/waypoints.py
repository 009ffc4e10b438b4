"""Paths from a CSV file of tip positions."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, sinc
from contarm_sim.paths import Path as TipPath
from contarm_sim.paths import require_duration


@dataclass(frozen=True)
class Waypoints:
    """Tip positions from a file.

    Attributes:
        positions: [m], shape (T, 3).
        times: [s], shape (T,), or None where the file has no column t.
        places: file and row of each, for messages.
    """

    positions: Array
    times: Array | None
    places: list[str]


def read_csv(file: str | Path) -> Waypoints:
    """Read tip positions from a CSV file with a header: `x,y,z` or `t,x,y,z`, in m and s.

    Raises:
        InputError: unreadable, empty, a missing column, or a bad cell, with its row and column.
    """
    where = str(file)
    try:
        text = Path(file).read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise InputError("file", f"unreadable ({error.strerror})", "a CSV file with columns x,y,z", where) from error
    except UnicodeDecodeError as error:
        raise InputError("file", "not text", "a CSV file with columns x,y,z", where) from error
    if "\0" in text:
        raise InputError("file", "not text", "a CSV file with columns x,y,z", where)
    try:
        lines = list(csv.reader(text.splitlines()))
    except csv.Error as error:
        raise InputError("file", f"not CSV ({error})", "a CSV file with columns x,y,z", where) from error
    rows = [(number, row) for number, row in enumerate(lines, 1) if any(cell.strip() for cell in row)]
    if not rows:
        raise InputError("file", "empty", "a CSV file with columns x,y,z or t,x,y,z", where)
    header = [cell.strip().lower() for cell in rows[0][1]]
    missing = [name for name in "xyz" if name not in header]
    if missing:
        raise InputError(
            "header", repr(",".join(header)), f"columns x,y,z or t,x,y,z (missing: {', '.join(missing)})", where
        )
    if any(header.count(name) > 1 for name in "txyz"):
        raise InputError("header", repr(",".join(header)), "each of x,y,z and t once", where)
    if len(rows) < 2:
        raise InputError("file", "without rows below its header", "at least one row of x,y,z", where)
    names = [name for name in "txyz" if name in header]
    values = np.array(
        [
            [_cell(row, header.index(name), name, number, where, len(header)) for name in names]
            for number, row in rows[1:]
        ]
    )
    times = values[:, 0] if "t" in names else None
    if times is not None and np.any(np.diff(times) <= 0):
        bad = int(np.argmax(np.diff(times) <= 0)) + 1
        raise InputError(
            f"t in row {rows[bad + 1][0]}",
            values[bad, 0],
            f"more than the row before ({values[bad - 1, 0]:g} s)",
            where,
        )
    return Waypoints(values[:, -3:], times, [f"{where}, row {number}" for number, _ in rows[1:]])


def _cell(row: list[str], column: int, name: str, number: int, where: str, width: int) -> float:
    if len(row) > width:
        raise InputError(f"row {number}", f"{len(row)} cells", f"{width}, as in the header", where)
    text = row[column].strip() if column < len(row) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"row {number}, column {name}", repr(text), "a finite number", where)
    return value


def from_waypoints(waypoints: Waypoints, length: float, duration: float | None = None) -> TipPath:
    """Return a smooth path through waypoints.

    Interpolates direction and distance relative to the dome with monotone cubics, so that between waypoints on
    the dome the path stays on it.

    Args:
        duration: [s]; default what the waypoints' times span, or 10 without times (then at even speed).

    Raises:
        InputError: fewer than two waypoints, or a duration that is not positive.
    """
    from scipy.interpolate import PchipInterpolator

    positions, times = waypoints.positions, waypoints.times
    if len(positions) < 2:
        raise InputError("waypoints", len(positions), "at least two rows")
    rho = np.hypot(positions[:, 0], positions[:, 1])
    half = np.arctan2(rho, positions[:, 2])
    lateral = positions[:, :2] * np.divide(half, rho, out=np.zeros_like(rho), where=rho != 0)[:, None]
    ratio = np.hypot(rho, positions[:, 2]) / (length * sinc(half))
    steps = np.diff(times) if times is not None else np.linalg.norm(np.diff(positions, axis=0), axis=1)
    if np.any(steps <= 0):
        bad = int(np.argmax(steps <= 0)) + 2
        raise InputError(
            "x,y,z", positions[bad - 1].tolist(), "a position other than the one before", waypoints.places[bad - 1]
        )
    knots = np.concatenate([[0.0], np.cumsum(steps)])
    smooth = PchipInterpolator(knots / knots[-1], np.column_stack([lateral, ratio]))

    def curve(s: Array) -> Array:
        value = smooth(s)
        half = np.hypot(value[:, 0], value[:, 1])
        distance = value[:, 2] * length * sinc(half)
        return distance[:, None] * np.column_stack([sinc(half)[:, None] * value[:, :2], np.cos(half)])

    total = duration if duration is not None else (knots[-1] if times is not None else 10.0)
    require_duration(total)
    return TipPath("waypoints", curve, total, even=times is None)

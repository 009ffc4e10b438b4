"""A force that changes over time, read from a table, as what holds an arm and what acts on it later."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.inputs import read_text
from contarm_sim.model.load import Load
from contarm_sim.motion.course import Course, forces_over_time, load_at, remaining
from contarm_sim.paths.table import read_table

_UNITS = {"t": "s", "fx": "N", "fy": "N", "fz": "N"}

_ALLOWED = "rows t,fx,fy,fz, a header above them if you like"


def forces_from_file(file: str | Path, load: Load, xi: float = 1.0) -> tuple[Load, Course]:
    """Return a load with the first force of a CSV file added, which holds the arm, and the course of that force.

    Args:
        file: rows t,fx,fy,fz [s, N], t rising from 0, straight lines between; the last one stays.
        load: what holds the arm beside it, and goes at once.
        xi: where the force acts, 0 base to 1 tip.

    Raises:
        InputError: not such a file, or a place off the arm.
    """
    name = str(file)
    table = read_table(read_text(file, _ALLOWED), _UNITS, {"time": "t"}, tuple(_UNITS), name)
    if set(table.columns) != set(_UNITS) or not table.rows:
        raise InputError("forces", f"a table with {','.join(table.columns) or 'no known column'}", _ALLOWED, name)
    rows = np.column_stack([table.columns[column] for column in _UNITS])
    try:
        course = forces_over_time(rows[:, 0], rows[:, 1:], remaining(load), xi)
        first = load_at(course, load, 0.0)[0]
    except InputError as error:
        raise error.located(name) from None
    return replace(load, wrenches=(*load.wrenches, *first.wrenches)), course

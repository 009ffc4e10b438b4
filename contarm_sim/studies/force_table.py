"""A force that changes over time, read from a table, as what holds an arm and what acts on it later."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.model.load import Load
from contarm_sim.motion.course import Course, forces_over_time, load_at, remaining

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
    try:
        lines = [line for line in Path(file).read_bytes().decode().splitlines() if line.strip()]
    except (OSError, UnicodeDecodeError) as error:
        said = getattr(error, "strerror", None) or "not text"
        raise InputError("forces", f"unreadable ({said})", _ALLOWED, name) from error
    if lines and lines[0].lstrip()[:1].isalpha():
        lines = lines[1:]
    try:
        rows = np.array([[float(word) for word in line.split(",")] for line in lines])
    except ValueError as error:
        raise InputError("forces", f"not a table ({error})", _ALLOWED, name) from error
    if rows.ndim != 2 or rows.shape[1] != 4:
        raise InputError("forces", f"a table of shape {rows.shape}", _ALLOWED, name)
    try:
        course = forces_over_time(rows[:, 0], rows[:, 1:], remaining(load), xi)
        first = load_at(course, load, 0.0)[0]
    except InputError as error:
        raise error.located(name) from None
    return replace(load, wrenches=(*load.wrenches, *first.wrenches)), course

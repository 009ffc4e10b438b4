"""Targets of the tip: positions, and directions or orientations beside them, as given or from a CSV file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.inputs import read_text
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.kinematics.inverse import rotation_from_quaternion
from contarm_sim.kinematics.inverse.checks import as_directions
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.paths.table import read_table

_POSITION, _DIRECTION, _QUATERNION = ("x", "y", "z"), ("dx", "dy", "dz"), ("qw", "qx", "qy", "qz")
_UNITS = {"t": "s"} | dict.fromkeys(_POSITION, "m") | dict.fromkeys((*_DIRECTION, *_QUATERNION), "-")


@dataclass(frozen=True)
class Targets:
    """T targets of the tip.

    Attributes:
        position: [m], shape (T, 3).
        direction: of the tip, unit vectors, shape (T, 3), or None.
        rotation: of the tip, shape (T, 3, 3), or None.
        places: file and row of each, for messages, or None.
        notes: what was converted, and which columns were not read, for people.
    """

    position: Array
    direction: Array | None = None
    rotation: Array | None = None
    places: list[str] | None = None
    notes: tuple[str, ...] = ()

    @property
    def turned(self) -> bool:
        """Whether a direction or an orientation is asked for."""
        return self.direction is not None or self.rotation is not None

    def place(self, index: int) -> str | None:
        """Return where a target stands in a file, or None; of one target repeated, where that one stands."""
        return None if self.places is None else self.places[min(index, len(self.places) - 1)]

    def repeated(self, count: int) -> Targets:
        """Return the first target so many times."""
        arrays = (self.position, self.direction, self.rotation)
        return Targets(*(None if a is None else np.repeat(a[:1], count, axis=0) for a in arrays))  # type: ignore[arg-type]

    def misses(self, tips: Array) -> tuple[Array, Array]:
        """Return distances [m] and angles [rad], each of shape (T,), of tips' frames, (T, 4, 4), to the targets."""
        goals = Goals(self.position, self.direction, self.rotation)
        return goals.apart(tips[:, :3, 3], tips[:, :3, :3])


def of_numbers(position: Any, direction: Any = None, quaternion: Any = None) -> Targets:
    """Return one target.

    Raises:
        InputError: numbers that are not finite, a direction of no length, a quaternion that is none, or both.
    """
    if direction is not None and quaternion is not None:
        raise InputError("--direction", "given with --quaternion", "one of them")
    turned = None if direction is None else as_directions(np.array([direction], dtype=float))
    rotation = None if quaternion is None else rotation_from_quaternion(np.array([quaternion], dtype=float))
    return Targets(as_vectors(np.array([position], dtype=float), 3, "tip"), turned, rotation)


def read_targets(file: str | Path) -> Targets:
    """Read targets from a CSV file with columns x,y,z, and perhaps dx,dy,dz or qw,qx,qy,qz, see `waypoints.read_csv`.

    Raises:
        InputError: unreadable, empty, a missing column, or a bad cell, with its row and column.
    """
    where = str(file)
    table = read_table(
        read_text(file, "a CSV file with columns x,y,z"), _UNITS, {"time": "t"}, ("t", "x", "y", "z"), where
    )
    turns = [names for names in (_DIRECTION, _QUATERNION) if any(name in table.columns for name in names)]
    for names in (_POSITION, *turns):
        missing = [name for name in names if name not in table.columns]
        if missing:
            found = ",".join(table.columns) or "no known column"
            allowed = f"columns {','.join(names)}, also with units, x [mm] (missing: {', '.join(missing)})"
            if names == _POSITION:
                allowed = f"columns x,y,z or t,x,y,z, also with units, x [mm] (missing: {', '.join(missing)})"
            raise InputError("header", repr(found), allowed, where)
    if len(turns) == 2:
        raise InputError("header", repr(",".join(table.columns)), "dx,dy,dz or qw,qx,qy,qz, not both", where)
    if not table.rows:
        raise InputError("file", "without rows below its header", "at least one row of x,y,z", where)
    columns = {names: np.column_stack([table.columns[name] for name in names]) for names in (_POSITION, *turns)}
    places = [f"{where}, row {number}" for number in table.rows]
    direction = rotation = None
    for names in turns:
        for row, place in zip(columns[names], places, strict=True):
            try:
                as_directions(row) if names == _DIRECTION else rotation_from_quaternion(row)
            except InputError as error:
                raise error.located(place) from None
        if names == _DIRECTION:
            direction = as_directions(columns[names])
        else:
            rotation = rotation_from_quaternion(columns[names])
    return Targets(columns[_POSITION], direction, rotation, places, tuple(f"{where}: {note}" for note in table.notes))

"""What tells the sections of an arm apart in pictures: a colour and a name for each, and those of its muscles.

An arm of one section has the plain names and colours that it always had.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.shape import backbone, bends_of
from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import hex_colour, muscle_colour, muscle_hex
from contarm_sim.view.colours import SIMULATED
from contarm_sim.view.workspace import around, hull

_COLOURS = ((0.30, 0.32, 0.36), (0.07, 0.45, 0.47), (0.55, 0.33, 0.12), (0.36, 0.27, 0.55), (0.16, 0.42, 0.20),
            (0.55, 0.20, 0.33))  # fmt: skip
"""Dark enough for lines on white and for disks in the scene; none is a muscle's, the path's or the target's."""

_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.5)), (0, (4, 1.2, 1, 1.2)), (0, (1, 1)), (0, (7, 1.5)), (0, (2, 1)))
_MARKS, _WIDTHS = "os^vDP", (3.6, 2.4, 1.4)
"""They tell sections apart without colour."""


def section_colour(number: int) -> tuple[float, float, float]:
    """Return red, green and blue of a section, numbered from 0."""
    return _COLOURS[number % len(_COLOURS)]


def section_hex(number: int) -> str:
    """Return the same colour as #rrggbb."""
    return hex_colour(section_colour(number))


def dashes(number: int) -> Any:
    """Return the dashes of a line of a section, or of a muscle of one, numbered from 0."""
    return _DASHES[number % len(_DASHES)]


def section_look(number: int) -> dict[str, Any]:
    """Return what a section's line looks like, as `plot` takes it."""
    return {"color": section_hex(number), "linestyle": dashes(number)}


def section_body(number: int) -> dict[str, Any]:
    """Return what a section looks like where the arm itself is drawn: thinner and thinner, in no dashes."""
    return {"color": section_hex(number), "linewidth": _WIDTHS[number % len(_WIDTHS)]}


def section_marks(number: int) -> dict[str, Any]:
    """Return what marks of a section look like, as `plot` takes it."""
    return {"color": section_hex(number), "linestyle": "none", "marker": _MARKS[number % len(_MARKS)],
            "fillstyle": "none"}  # fmt: skip


def muscle_colours(arm: Arm) -> Array:
    """Return red, green and blue of all muscles, shape (n, 3): each section's first is red, its second blue."""
    return np.array([muscle_colour(i)[:3] for group in arm.groups for i in range(group.routing.count)]).reshape(-1, 3)


def muscle_hexes(arm: Arm) -> list[str]:
    """Return the same colours as #rrggbb."""
    return [muscle_hex(i) for group in arm.groups for i in range(group.routing.count)]


def tube_radii(arm: Arm) -> list[float]:
    """Return the radius of a tube about all muscles that run through each section [m]."""
    out = []
    for number in range(len(arm.sections)):
        own = [group for group in arm.groups if group.crosses(number)]
        out.append(max([group.routing.radius + 0.5 * group.law.diameter for group in own], default=arm.disk_radius))
    return out


def pressure_limits(arm: Arm) -> Array:
    """Return the lowest and the highest pressure of the muscles of each group [Pa], shape (groups, 2).

    0 and inf for muscles that no pressure drives.
    """
    return np.array([group.law.pressure_limits for group in arm.groups]).reshape(-1, 2)


def section_places(arm: Arm, pieces: int) -> list[Array]:
    """Return places along each section, so many pieces long, as normalised arc lengths of the arm, shape (K,)."""
    if len(arm.sections) == 1:
        return [np.linspace(0.0, 1.0, pieces + 1)]
    ends = np.cumsum([0.0, *(section.length for section in arm.sections)]) / arm.length
    ends[-1] = 1.0
    return [np.linspace(start, end, pieces + 1) for start, end in pairwise(ends)]


def bend_words(bend: Any, arm: Arm) -> str:
    """Return a bend [rad], shape (2 S,), in whole degrees: angle and plane of each section.

    Of several sections the plane stands in brackets, to save room.
    """
    words = []
    for own in bends_of(bend, arm):
        angle, plane = (float(np.round(np.degrees(x))) for x in arc.to_polar(own))
        plane = 180.0 if plane == -180 else plane
        where = f"towards {plane + 0.0:.0f}°" if len(arm.sections) == 1 else f"({plane + 0.0:.0f}°)"
        words.append(f"{angle:.0f}° {where}")
    return ", ".join(words)


def base_rim(arm: Arm, points: int = 49) -> Array:
    """Return the rim of the base plate [m], shape (points, 3), the first again as the last."""
    turn = np.linspace(0, 2 * np.pi, points)
    return arm.disk_radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)


def reachable_tips(arm: Arm, rows: int, columns: int, largest: float = np.pi - 1e-9) -> Array:
    """Return the dome of reachable tips, or the hull of those of several sections [m], shape (T, columns, 3).

    Args:
        rows: bend angles of the dome; the hull has its own number of rows.
        columns: planes, the first again as the last.
        largest: bend angle that the dome ends at [rad].
    """
    planes = np.linspace(0, 2 * np.pi, columns)
    if len(arm.sections) == 1:
        return arc.position(arc.from_polar(np.linspace(0, largest, rows)[:, None], planes), arm.length)
    return around(hull(backbone(arm), rows), planes)


def backbone_lines(stations: Array, arm: Arm) -> list[tuple[str, str, Array]]:
    """Return name, colour (#rrggbb) and stations of each section of a backbone with stations of shape (N + 1, 3)."""
    if len(arm.sections) == 1:
        return [("backbone", SIMULATED, stations)]
    ends = np.cumsum([0, *(section.links for section in arm.sections)])
    return [
        (f"section {number + 1}", section_hex(number), stations[start : end + 1])
        for number, (start, end) in enumerate(pairwise(ends))
    ]

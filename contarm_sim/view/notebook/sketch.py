"""Small pictures as SVG: an arm and its tip's path from the side, and a curve. Ink has the notebook's text colour."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.colours import hex_colour
from contarm_sim.model.world import World
from contarm_sim.view.colours import SIMULATED

INK = "currentColor"
POINTS = 120
"""Points of a line, at most."""

_ROOM = 14
"""Space around what is drawn [pixels]."""

_BESIDE = 0.2
"""How far beside all else objects are drawn, in its size."""

_ABOVE = math.radians(15)
"""How far above the horizon the eye is: circles are seen as such."""


@dataclass(frozen=True)
class Line:
    """A line through points in the base frame [m], shape (K, 3): colour, width [pixels], opacity, dashes."""

    points: Array
    colour: str = INK
    width: float = 1.5
    opacity: float = 1.0
    dashes: str = ""


FREE = World()

Things = Sequence[tuple[Any, Array]]
"""Colours of objects, red, green and blue from 0 to 1, and their vertices in the base frame [m], shape (K, 3)."""


def side_view(
    lines: Sequence[Line], words: str, world: World = FREE, width: int = 220, height: int = 190, things: Things = ()
) -> str:
    """Return lines from the side from which they are widest, a little above, with the base, a scale and gravity.

    Args:
        words: what the picture shows, for those who hear it.
        world: says what is up, and where gravity points.
        things: objects, of which what is near is drawn.
    """
    up = np.array(world.up)
    points = np.concatenate([line.points for line in lines])
    flat = points - (points @ up)[:, None] * up
    right = np.linalg.svd(flat, full_matrices=False)[2][0] if np.ptp(flat, axis=0).max() > 0 else _across(up)
    right = right - (right @ up) * up  # of points that all lie along `up`, rounding
    right /= np.linalg.norm(right) if np.linalg.norm(right) > 0.5 else 1.0
    if right @ np.array([1.0, 0.31, 0.17]) < 0:  # one of the two sides, always the same
        right = -right
    away = np.cross(up, right)
    view = np.stack([right, -math.cos(_ABOVE) * up - math.sin(_ABOVE) * away], axis=1)
    seen = np.concatenate([points @ view, np.zeros((1, 2))])
    flats = [(colour, _near(vertices @ view, seen)) for colour, vertices in things]
    seen = np.concatenate([seen, *(flat for _, flat in flats)])
    low, span = seen.min(axis=0), np.maximum(np.ptp(seen, axis=0), 1e-9)
    room = np.array([width - 2 * _ROOM, height - 2 * _ROOM - 16.0])
    scale = float((room / span).min())
    start = _ROOM + (room - scale * span) / 2 - scale * low

    drawn = [_base(start, np.array([0.0, 0.0, 1.0]) @ view)]
    drawn += [_area(start + scale * flat, colour) for colour, flat in flats if len(flat)]
    drawn += [_path(start + scale * (line.points @ view), line) for line in lines]
    drawn.append(_scale(scale, span.max(), height))
    if any(world.gravity):
        drawn.append(_arrow(width, height, np.array(world.gravity) @ view))
    return _svg(width, height, drawn, words)


def curve(values: Array, words: str, width: int = 220, height: int = 60) -> str:
    """Return a curve of values over their places, from 0 to the largest."""
    top = float(np.max(values, initial=0.0)) or 1.0
    across = np.linspace(4, width - 4, len(values)) if len(values) > 1 else np.array([width / 2])
    places = np.column_stack([across, height - 5 - (height - 10) * np.asarray(values) / top])
    floor = f'<path d="M4 {height - 5}H{width - 4}" stroke="{INK}" stroke-opacity=".4"/>'
    return _svg(width, height, [floor, _path(places, Line(values, INK, 1.3))], words)


def _across(up: Array) -> Array:
    """Return a direction at right angles to another, +X where that can be."""
    found = np.array([1.0, 0.0, 0.0]) - up[0] * up
    return found / np.linalg.norm(found) if np.linalg.norm(found) > 0.1 else np.array([0.0, 1.0, 0.0])


def _path(places: Array, line: Line) -> str:
    step = max(1, math.ceil(len(places) / POINTS))
    kept = places[::step] if (len(places) - 1) % step == 0 else np.concatenate([places[::step], places[-1:]])
    if len(kept) == 1:
        return f'<circle cx="{kept[0, 0]:.1f}" cy="{kept[0, 1]:.1f}" r="4.5" fill="{line.colour}"/>'
    d = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in kept)
    more = f' stroke-opacity="{line.opacity:g}"' if line.opacity < 1 else ""
    more += f' stroke-dasharray="{line.dashes}"' if line.dashes else ""
    return f'<path d="{d}" stroke="{line.colour}" stroke-width="{line.width:g}"{more}/>'


def _near(flat: Array, seen: Array) -> Array:
    """Return the part of an object's vertices that is near what is seen, shape (K, 2); none of what is far off."""
    room = _BESIDE * float(np.ptp(seen, axis=0).max())
    low, high = seen.min(axis=0) - room, seen.max(axis=0) + room
    far = np.any(flat.min(axis=0) > high) or np.any(flat.max(axis=0) < low)
    return flat[:0] if far else flat.clip(low, high)


def _area(places: Array, colour: Any) -> str:
    """Return the outline of an object, filled."""
    from scipy.spatial import ConvexHull

    if np.ptp(places, axis=0).min() < 1e-6:
        return ""
    d = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places[ConvexHull(places).vertices]) + "Z"
    tint = hex_colour(colour)
    return f'<path d="{d}" fill="{tint}" fill-opacity=".35" stroke="{tint}" stroke-width="1"/>'


def _base(at: Array, axis: Array) -> str:
    """Return the base plate, at right angles to the straight arm as it is seen."""
    size = float(np.linalg.norm(axis))
    x, y = (13 * np.array([-axis[1], axis[0]]) / size) if size > 0.1 else (13.0, 0.0)
    ends = f"M{at[0] - x:.1f} {at[1] - y:.1f}L{at[0] + x:.1f} {at[1] + y:.1f}"
    return f'<path d="{ends}" stroke="{INK}" stroke-width="4" stroke-linecap="butt"/>'


def _scale(scale: float, span: float, height: int) -> str:
    """Return a line of a round length, and that length."""
    wanted = 0.4 * span
    power = 10.0 ** math.floor(math.log10(wanted))
    length = max(step for step in (power, 2 * power, 5 * power) if step <= wanted)
    said, y = (f"{1e3 * length:g} mm" if length < 1 else f"{length:g} m"), height - 7
    line = f'<path d="M6 {y}h{scale * length:.1f}" stroke="{INK}" stroke-width="1.5"/>'
    return line + f'<text x="6" y="{y - 5}" font-size="11" fill="{INK}" stroke="none">{said}</text>'


def _arrow(width: int, height: int, pull: Array) -> str:
    """Return an arrow that points as gravity does in the picture, in its corner."""
    x, y, turn = width - 14, height - 20, math.degrees(math.atan2(pull[1], pull[0])) - 90
    arrow = f'<path d="M{x} {y - 14}v26m-4 -6l4 7l4 -7" stroke="{INK}" stroke-width="1.3"'
    arrow += f' transform="rotate({turn:.0f} {x} {y})"/>' if abs(turn) > 0.5 else "/>"
    return arrow + f'<text x="{x - 24}" y="{y + 2}" font-size="12" font-style="italic" fill="{INK}">g</text>'


def _svg(width: int, height: int, parts: Sequence[Any], words: str) -> str:
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}"'
    style = 'fill="none" stroke-linecap="round" stroke-linejoin="round" font-family="system-ui,sans-serif"'
    return f'{head} role="img" aria-label="{escape(words)}" {style}>{"".join(parts)}</svg>'


def tip_line(points: Array) -> Line:
    """Return the line of a simulated tip."""
    return Line(points, SIMULATED, 1.6)

"""Three-dimensional axes of figures: the world, Z up, the arm as it stands or hangs, equal scales, which way is down.

Without perspective, as plain lines on plane axes: nothing is cut off, and layouts treat it as any other panel.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf.scene import base_rotation, world_gravity
from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import hex_colour
from contarm_sim.model.objects import Object
from contarm_sim.view.colours import FAINT, GRID, LIMIT, PLATE, TARGET
from contarm_sim.view.outlines import placed_objects
from contarm_sim.view.sections import base_rim, reachable_tips
from contarm_sim.view.style import Sheet

MM = 1e3

_AZIMUTH, _ELEVATION = math.radians(-56.0), math.radians(20.0)
"""Where the eye is, seen from the middle."""

_SCREEN = np.array(
    [
        [-math.sin(_AZIMUTH), math.cos(_AZIMUTH), 0.0],
        [-math.sin(_ELEVATION) * math.cos(_AZIMUTH), -math.sin(_ELEVATION) * math.sin(_AZIMUTH), math.cos(_ELEVATION)],
    ]
)
"""Right and up of the figure in the world, shape (2, 3)."""

_RIM, _CORNERS = 0.04, (0.09, 0.09, 0.03)
"""Room around what is drawn, and ends of x, y and z without numbers, where those of two would meet [share]."""

_BESIDE = 0.07
"""How far beside the box gravity is drawn [share of its width]."""

_NEAR = 0.25
"""How far beyond all else objects are shown [lengths]."""

_NUMBERS, _NAMES, _FARTHER = 9.0, (22.5, 28.0), (6.0, 11.0)
"""How far numbers of x and y, and their names, are from the axes [pt], and how much farther long names are."""


class Space(Axes):
    """Axes of the world, Z up, with the base at the origin, in mm: give points in the base frame [m], then `settle`.

    The world is the base frame turned so that gravity points down, unless the arm states how it stands; without either
    the two are one. Where they are not, the axes' names say that they are the world's.
    """

    def __init__(self, *place: Any, arm: Arm, **given: Any) -> None:
        super().__init__(*place, **given)
        self._planes: list[tuple[Object, Array]] = []
        self._arm, self._turn, self._seen = arm, base_rotation(arm), [np.zeros((1, 3))]
        self._frame = "" if np.allclose(self._turn, np.eye(3)) else "world "
        self.set_axis_off()
        self.set_aspect("equal", anchor="N")
        self._plate()

    def world(self, points: Array) -> Array:
        """Return points of the base frame [m], shape (..., 3), in the world [mm]."""
        return np.asarray(MM * np.asarray(points, dtype=float) @ self._turn.T)

    @property
    def broadside(self) -> float:
        """Bending plane [rad] that is seen least foreshortened, towards the right."""
        (x, y, z), up = (_SCREEN @ self._turn).T, np.array([0.0, 1.0])
        seen = z if np.linalg.norm(z) > 1e-9 else up
        out = math.atan2(seen[0] * y[1] - seen[1] * y[0], seen[0] * x[1] - seen[1] * x[0])
        return out if math.cos(out) * x[0] + math.sin(out) * y[0] >= 0 else out + math.pi

    def trace(self, points: Array, **look: Any) -> Line2D:
        """Draw a line through points [m], shape (K, 3), later ones over earlier ones; `look` as `plot` takes it.

        The line keeps what it shows as `line.world`, in mm.
        """
        placed = self.world(points)
        self._seen.append(placed)
        (line,) = self.plot(*(_SCREEN @ placed.T), **look)
        line.world = placed  # type: ignore[attr-defined]
        return line

    def net(self, points: Array, **look: Any) -> None:
        """Draw a net of thin lines through points [m], shape (rows, columns, 3)."""
        look = {"color": FAINT, "linewidth": 0.4, "zorder": 1} | look
        for line in (*points, *np.moveaxis(points, 1, 0)):
            self.trace(line, **look)

    def reachable(self, rows: int = 9, columns: int = 25) -> None:
        """Draw the dome of reachable tips, or the hull of those of several sections, as a net."""
        self.net(reachable_tips(self._arm, rows, columns))

    def objects(self, poses: Array | None = None) -> None:
        """Draw what the arm can touch, as outlines behind all else; planes as far as the picture reaches.

        Args:
            poses: of the free objects, see `Trajectory.objects`, shape (F, 7); default where they begin.
        """
        names: dict[str, list[str]] = {}
        for each, points, _ in placed_objects(self._arm, poses):
            placed = self.world(points)
            if each.shape == "plane":
                self._planes.append((each, placed))
                continue
            every = np.concatenate(self._seen)
            room = _NEAR * MM * self._arm.length
            low, high = every.min(axis=0) - room, every.max(axis=0) + room
            if np.all(placed.min(axis=0) <= high) and np.all(placed.max(axis=0) >= low):
                self._seen.append(placed.clip(low, high))
                if self._outline(each, placed):
                    names.setdefault(hex_colour(each.colour), []).append(each.name)
        for colour, alike in names.items():
            self.fill([], [], facecolor=colour, alpha=0.35, linewidth=0, label=", ".join(alike))

    def _outline(self, each: Object, placed: Array) -> bool:
        """Fill the outline of an object with points of the world [mm], shape (K, 3), which is convex, if it has one."""
        flat = placed @ _SCREEN.T
        if len(flat) < 3 or np.linalg.matrix_rank(flat - flat[0], tol=1e-6 * MM) < 2:
            return False
        from scipy.spatial import ConvexHull

        rim = flat[ConvexHull(flat).vertices]
        colour = hex_colour(each.colour)
        self.fill(*rim.T, facecolor=colour, alpha=0.35, linewidth=0, zorder=1.2)
        self.plot(*np.vstack([rim, rim[:1]]).T, color=colour, linewidth=0.8, zorder=1.2)
        return True

    def note(self, point: Array, words: str, away: Array, **look: Any) -> None:
        """Write words beside a point [m], in a direction from it; `look` as matplotlib's texts take it."""
        spot, towards = _SCREEN @ self.world(point), _SCREEN @ self.world(away)
        beside = 9.0 * towards / max(float(np.linalg.norm(towards)), 1e-12)
        at: dict[str, Any] = {"ha": "center", "va": "center", "annotation_clip": False}
        self.annotate(words, tuple(spot), tuple(beside), textcoords="offset points", **at | look)

    def settle(self, legend: bool = True) -> None:
        """Set the limits, draw axes, gravity and, beside the picture on a page or above it in a column, the legend."""
        seen = np.concatenate(self._seen)
        low, high = seen.min(axis=0), seen.max(axis=0)
        span = float((high - low).max())
        short = np.maximum(0.3 * span - (high - low), 0)
        low, high = low - 0.5 * short - _RIM * span, high + 0.5 * short + _RIM * span
        corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1)
        (left, bottom), (right, top) = (_SCREEN @ corners).min(axis=1), (_SCREEN @ corners).max(axis=1)
        self.set(xlim=(left, right), ylim=(bottom, top))
        wide = self.figure.wide if isinstance(self.figure, Sheet) else False
        for each, placed in self._planes:
            self._outline(each, clipped(placed, low, high))
        self._box(low, high, (span / 5.0) if wide else (span / 3.2))
        self._gravity(low, high)
        if legend and self.get_legend_handles_labels()[0]:
            look = {"loc": "upper right", "bbox_to_anchor": (-0.06, 1.0)}
            self.legend(**look if wide else {"loc": "lower left", "bbox_to_anchor": (-0.1, 1.0)})

    def _plate(self) -> None:
        """Draw the base plate."""
        placed = self.world(base_rim(self._arm))
        self._seen.append(placed)
        self.fill(*(_SCREEN @ placed.T), color=PLATE, linewidth=0, zorder=1.5)

    def _box(self, low: Array, high: Array, least_step: float) -> None:
        """Draw floor and back walls with lines at the ticks, and the three axes with their numbers and names."""
        steps = [_step(least_step)] * 2 + [_step((high[2] - low[2]) / 6.5)]
        marks = [_ticks(*ends) for ends in zip(low, high, steps, _CORNERS, strict=True)]
        back = (low[0], high[1], low[2])  # the walls that the eye sees the inside of
        for along in range(3):
            for across in range(3):
                if along == across:
                    continue
                wall = 3 - along - across
                for mark in (low[across], *marks[across], high[across]):
                    ends = np.empty((2, 3))
                    ends[:, along], ends[:, across], ends[:, wall] = (low[along], high[along]), mark, back[wall]
                    self.plot(*(_SCREEN @ ends.T), color=GRID, linewidth=0.5, zorder=0.5)
        edges = (
            ("x", np.array([[t, low[1], low[2]] for t in (low[0], high[0])])),
            ("y", np.array([[high[0], t, low[2]] for t in (low[1], high[1])])),
            ("z", np.array([[low[0], low[1], t] for t in (low[2], high[2])])),
        )
        for axis, (name, ends) in enumerate(edges):
            self._axis(axis, name, ends, marks[axis])

    def _axis(self, axis: int, name: str, ends: Array, marks: Array) -> None:
        """Draw one edge of the box as an axis."""
        start, end = (_SCREEN @ ends.T).T
        self.plot(*zip(start, end, strict=True), color=LIMIT, linewidth=0.6, zorder=0.6)
        along = (end - start) / np.linalg.norm(end - start)
        out = np.array([-1.0, 0.0]) if axis == 2 else np.array([along[1], -along[0]])
        look: dict[str, Any] = {"textcoords": "offset points", "annotation_clip": False}
        for mark in marks:
            place = ends[0].copy()
            place[axis] = mark
            spot = tuple(_SCREEN @ place)
            self.annotate("", spot, tuple(3 * out), arrowprops={"arrowstyle": "-", "color": LIMIT, "linewidth": 0.6,
                          "shrinkA": 0, "shrinkB": 0}, **look)  # fmt: skip
            far, beside = (5.0, "right") if axis == 2 else (_NUMBERS, "center")
            words = f"{mark:.6g}".replace("-", "\N{MINUS SIGN}")
            self.annotate(words, spot, tuple(far * out), ha=beside, va="center", **look)
        words = f"{self._frame}{name} [mm]"
        if axis == 2:
            self.annotate(words, tuple(end), (0, 5), ha="center", va="bottom", **look)
        else:
            far = _NAMES[axis] + (_FARTHER[axis] if self._frame else 0.0)
            self.annotate(words, tuple(0.5 * (start + end)), tuple(far * out), ha="center", va="center", **look)

    def _gravity(self, low: Array, high: Array) -> None:
        """Draw an arrow along gravity beside the right edge."""
        pull = world_gravity(self._arm)
        if not pull.any():
            return
        shaft = 0.3 * float((high - low).max()) * (_SCREEN @ pull) / float(np.linalg.norm(pull))
        left, right = self.get_xlim()
        beside = _BESIDE * (right - left)
        right += beside
        self.set_xlim(left, right + beside)
        middle = np.array([right, (_SCREEN @ (0.5 * (low + high)))[1]])
        start = middle - 0.5 * shaft - np.array([max(shaft[0], 0.0), 0.0])
        gravity_arrow(self, start, start + shaft)
        gravity_name(self, start, (0, 3), ha="center", va="bottom")


def gravity_arrow(axes: Any, start: Array, end: Array) -> None:
    """Draw an arrow along gravity, from one place of axes to another, both of shape (2,)."""
    look = {"arrowstyle": "-|>,head_width=0.25,head_length=0.5", "color": TARGET, "linewidth": 1.4, "shrinkA": 0,
            "shrinkB": 0}  # fmt: skip
    axes.annotate("", tuple(end), tuple(start), arrowprops=look, annotation_clip=False)


def gravity_name(axes: Any, place: Array, beside: tuple[float, float], **look: Any) -> None:
    """Name that arrow, so far [pt] beside a place of the axes, of shape (2,); `look` as matplotlib's texts take it."""
    look = {"textcoords": "offset points", "color": TARGET, "annotation_clip": False} | look
    axes.annotate("gravity", tuple(place), beside, **look)


def add_space(sheet: Any, arm: Arm, *place: Any) -> Space:
    """Add such axes to a sheet, at a place as `add_subplot` takes it."""
    out = sheet.add_subplot(*place, axes_class=Space, arm=arm)
    assert isinstance(out, Space)
    return out


def clipped(polygon: Array, low: Array, high: Array) -> Array:
    """Return what of a plane convex polygon, shape (K, 3), is within a box: Sutherland and Hodgman's way."""
    found = list(polygon)
    for axis, limit, side in [(axis, end[axis], sign) for end, sign in ((low, 1), (high, -1)) for axis in range(3)]:
        before, found = found, []
        for one, other in zip(before, [*before[1:], *before[:1]], strict=True):
            a, b = side * (one[axis] - limit), side * (other[axis] - limit)
            if a >= 0:
                found.append(one)
            if (a < 0 < b) or (b < 0 < a):
                found.append(one + a / (a - b) * (other - one))
    return np.array(found).reshape(-1, 3)


def _step(least: float) -> float:
    """Return the first of 1, 2, 5, 10, ... and their tenths that is at least so much."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(power * first for first in (1, 2, 5, 10) if power * first >= 0.999 * least)


def _ticks(low: float, high: float, step: float, clear: float) -> Array:
    """Return multiples of a step between two limits, none within a share of their distance from them.

    Where there are fewer than two, those of the next smaller round step that has two.
    """
    rim = clear * (high - low)
    while True:
        found = np.array(step * np.arange(math.ceil((low + rim) / step), math.floor((high - rim) / step) + 1))
        if len(found) > 1:
            return found
        step = _step(0.4 * step)

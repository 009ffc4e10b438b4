"""What several sections reach, in a plane through the axis: where tips can be, how often, and how well."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics import sections
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import BLACK, HELD, PURPLE
from contarm_sim.view.once import once
from contarm_sim.view.sections import section_body, section_hex, section_places
from contarm_sim.view.space import gravity_arrow, gravity_name
from contarm_sim.view.style import Sheet
from contarm_sim.view.trim import trim
from contarm_sim.view.workspace import Grid, Workspace, folds, hull, planar_tips, workspace

MM = 1e3
CELLS, POSES = 64, 1_000_000
"""Cells of a map in the length of the arm, and poses that it is drawn from."""

_BY_THE_AXIS = 0.06
"""Cells so near to the axis [share of the length] are too small to hold enough poses. What is shown is even over the
distance from the axis, so flat there: they show the mean of all of them, or what the next one does.
"""

_workspace, _planar_tips, _hull = once(workspace), once(planar_tips), once(hull)


class _Plane:
    """A plane through the axis, the arm standing or hanging in it: distances from the axis and heights, in mm."""

    def __init__(self, sheet: Sheet, arm: Arm) -> None:
        self.ax: Any = sheet.subplots()
        self.backbone, self._upwards = shape.backbone(arm), -MM if arm.world.up[2] < -0.9999 else MM
        self._outer = _hull(self.backbone)
        self._pulled = any(arm.gravity) and abs(abs(arm.gravity[2]) - np.linalg.norm(arm.gravity)) < 1e-9

    def placed(self, distances: Array, heights: Array) -> tuple[Array, Array]:
        """Return distances and heights [m] as they are drawn [mm]."""
        return MM * distances, self._upwards * heights

    def outline(self) -> tuple[Array, Array]:
        """Return the edge of the convex hull of tips on one side."""
        return self.placed(*self._outer.T)

    def settle(self, sheet: Sheet, most: float) -> None:
        """Set limits and names of the axes, and draw gravity's direction."""
        wide, heights = MM * self._outer[:, 0].max(), self._upwards * self._outer[:, 1]
        edge, beside = 0.06 * wide, 0.12 * wide if self._pulled else 0.0
        low, high = min(heights.min(), 0.0) - edge, max(heights.max(), 0.0) + edge
        left = -wide - edge - beside
        self.ax.set(xlim=(left, wide + edge), ylim=(low, high))
        self.ax.set_aspect("equal", anchor="N")
        self.ax.set_xlabel("distance from the axis [mm]")
        self.ax.set_ylabel("height z [mm]" if self._pulled else "along the base's axis, z [mm]")
        if self._pulled:
            start, shaft = np.array([left + edge, high - edge]), np.array([0.0, 0.5 * wide])
            gravity_arrow(self.ax, start, start - shaft)
            gravity_name(self.ax, start, (4, 0), va="top", rotation=90)
        trim(sheet, most)


def slices(sheet: Sheet, arm: Arm) -> None:
    """Draw where the tip can be in a plane through the axis, its convex hull, and arms bent in that plane.

    Of two sections also the curves at which poses fold or bends are at their limits: the edges are among them.
    """
    sheet.heading("Reachable tips in a plane through the axis, and three poses")
    plane = _Plane(sheet, arm)
    ax, backbone = plane.ax, plane.backbone
    _fill(plane, HELD)
    ax.fill([], [], color=HELD, label="reachable tips")
    for side in (-1, 1):
        distances, heights = plane.outline()
        ax.plot(side * distances, heights, color=BLACK, linewidth=0.9, linestyle=(0, (4, 2)))
    ax.plot([], [], color=BLACK, linewidth=0.9, linestyle=(0, (4, 2)), label="convex hull")
    if len(backbone) == 2:
        for curve in folds(backbone):
            ax.plot(*plane.placed(*curve.T), color=PURPLE, linewidth=0.9)
        ax.plot([], [], color=PURPLE, linewidth=0.9, label="folds and limits")
    _draw_examples(plane, arm)
    beside = {"loc": "upper left", "bbox_to_anchor": (1.02, 1.0)}
    ax.legend(**beside if sheet.wide else {"loc": "lower left", "bbox_to_anchor": (-0.15, 1.0)})
    plane.settle(sheet, 105 if sheet.wide else 135)


def _fill(plane: _Plane, colour: Any) -> Any:
    """Fill what tips reach on both sides of the axis; return what draws it."""
    heights, distances, both = _reached(plane.backbone, CELLS, POSES)
    return plane.ax.contourf(*plane.placed(distances, heights), both.T, [0.5, np.inf], colors=[colour])


@once
def _reached(backbone: Backbone, cells: int, poses: int) -> tuple[Array, Array, Array]:
    """Return heights, distances on both sides [m], and how much of such cells and those around tips reach (1: all).

    Drawn poses reach them, or planar ones, which find the edges.
    """
    grid = Grid.over(backbone, 2 * cells)
    reached = np.zeros(grid.shape, dtype=bool)
    tips = np.insert(_planar_tips(backbone), 1, 0.0, axis=1)
    reached.ravel()[grid.cell(tips)] = True
    coarse = _workspace(backbone, cells, poses)
    column = np.minimum((grid.distances / coarse.grid.size).astype(int), coarse.grid.shape[0] - 1)
    row = ((grid.heights - coarse.grid.low) / coarse.grid.size).astype(int)
    reached |= _inner(coarse.reached)[np.ix_(column, np.clip(row, 0, coarse.grid.shape[1] - 1))]
    both = _smooth(_smooth(np.concatenate([reached[::-1], reached]).astype(float)))
    return grid.heights, np.concatenate([-grid.distances[::-1], grid.distances]), both


def _smooth(values: Array) -> Array:
    """Return the means over each cell and its eight neighbours."""
    padded = np.pad(values, 1)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return (rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]) / 9


def _inner(reached: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the cells whose neighbours are all reached too; what is beyond the axis or the grid counts as reached."""
    padded = np.pad(reached, 1, constant_values=False)
    padded[0] = padded[1]
    return padded[1:-1, 1:-1] & padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]


def _draw_examples(plane: _Plane, arm: Arm) -> None:
    """Draw three planar arms: straight, bent one way, bent one way and back."""
    limits, ax = np.array(plane.backbone.limits), plane.ax
    signs = np.where(np.arange(len(limits)) % 2, -1.0, 1.0)
    for angles in (0 * limits, 0.6 * limits / np.sqrt(len(limits)), -0.75 * limits * signs):
        bends = np.stack([angles, 0 * angles], axis=-1)
        for number, xi in enumerate(section_places(arm, 40)):
            line = np.stack(plane.placed(*sections.position(bends, plane.backbone, xi)[:, [0, 2]].T))
            ax.plot(*line, **section_body(number))
            ax.plot(*line[:, -1], "o", color=section_hex(number), markersize=4)
    for number in range(len(limits)):
        limit = np.degrees(limits[number])
        ax.plot([], [], **section_body(number), label=f"section {number + 1}, to {limit:.0f}°")


def density(sheet: Sheet, arm: Arm) -> None:
    """Draw how much of all poses, drawn evenly from each section's disk of bends, have their tip in a volume."""
    sheet.heading("Share of all poses whose tip is there")
    backbone = shape.backbone(arm)
    found = _workspace(backbone, CELLS, POSES)
    near = found.grid.distances < _BY_THE_AXIS * backbone.length
    volumes, values = found.grid.volumes[near], 0.1 * found.density
    values[near] = (values[near] * volumes).sum(axis=0) / volumes.sum()
    _draw_map(sheet, arm, found, values, "share of poses [% per litre]")


def dexterity(sheet: Sheet, arm: Arm) -> None:
    """Draw how well the tip does at a place: by the directions that it can have, or by how it can move.

    Three sections and more reach a place in directions of a whole range, whose share of all directions says how free a
    tool is. Two sections have a single curve of directions, a share of nothing; of them the figure shows the smallest
    singular value of the position's Jacobian, of the best pose: how far the tip moves for one radian of bends where
    it moves least.
    """
    backbone = shape.backbone(arm)
    if len(backbone) < 3:
        sheet.heading("How far the best pose moves the tip where it moves it least")
        found = _workspace(backbone, CELLS, POSES)
        _draw_map(sheet, arm, found, MM * found.slowest, "least tip motion [mm/rad]")
    else:
        sheet.heading("Share of all directions that the tip can have there")
        found = _workspace(backbone, CELLS // 2, POSES)
        values = 100 * found.directions
        beside = int(np.argmax(found.grid.distances > 2 * _BY_THE_AXIS * backbone.length))
        values[:beside] = np.maximum(values[:beside], values[beside])
        _draw_map(sheet, arm, found, values, "tip directions [% of all]")


def _draw_map(sheet: Sheet, arm: Arm, found: Workspace, values: Array, label: str) -> None:
    """Draw values over what is reached, on both sides of the axis; its edge is that of `slices`."""
    from matplotlib import colormaps
    from matplotlib.ticker import MaxNLocator

    plane, size = _Plane(sheet, arm), found.grid.size
    colours = colormaps["viridis"]
    edge = _fill(plane, colours(0.0))
    distances = size * np.arange(found.grid.shape[0] + 1, dtype=float)
    heights = found.grid.heights - 0.5 * size
    heights = np.append(heights, heights[-1] + size)
    shown = np.where(found.reached, values, np.nan)
    shown, distances = np.concatenate([shown[::-1], shown]), np.concatenate([-distances[:0:-1], distances])
    top = float(np.nanpercentile(shown, 99.5))
    places = plane.placed(distances, heights)
    mesh = plane.ax.pcolormesh(*places, shown.T, vmin=0, vmax=top, cmap=colours, rasterized=True)
    mesh.set_clip_path(edge.get_paths()[0], plane.ax.transData)
    bar = plane.ax.inset_axes((1.03, 0.0, 0.045, 1.0))
    marks = np.asarray(MaxNLocator(6).tick_values(0, top))
    sheet.colorbar(mesh, cax=bar, label=label, extend="max", ticks=marks[marks <= top])
    plane.settle(sheet, 105)

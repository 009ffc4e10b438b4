"""The poses that reach a target past objects: blocked ones, clear ones, and the one that was chosen."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim import planning
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.limits import angles_of
from contarm_sim.mechanics import shape
from contarm_sim.mjcf.surfaces import placed_surface
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import BLACK, LIMIT, ORANGE, SKY, TARGET
from contarm_sim.view.sections import section_body, section_hex, section_places
from contarm_sim.view.space import Space, add_space
from contarm_sim.view.style import Sheet
from contarm_sim.view.wireframes import draw_object

_POINTS, _DRAWN = 121, 30
"""Samples of a branch, and how many poses of a curve are drawn."""

_CLEAR, _BLOCKED = SKY, LIMIT
_CHOSEN: dict[str, Any] = {"color": ORANGE, "linestyle": "", "marker": "D", "zorder": 3}
_MARGIN: dict[str, Any] = {"color": LIMIT, "linestyle": ":", "linewidth": 1.0, "zorder": 1}
_JOINED = 0.7  # poses of a curve are no farther apart [rad]


def avoiding(
    sheet: Sheet, arm: Arm, target: Array, found: planning.Avoiding, direction: Any = None, rotation: Any = None
) -> None:
    """Draw the objects, the poses that reach a target, and the clear one that was chosen as the tube that it is."""
    curves = planning.solutions(arm, target, found.margin, direction, rotation, _POINTS)
    sheet.heading("Poses that reach a point, and the one that keeps clear")
    sheet.tall(88 if sheet.wide else 150)
    layout = {"width_ratios": [1.35, 1]} if sheet.wide else {"height_ratios": [1.5, 1]}
    grid = sheet.add_gridspec(*((1, 2) if sheet.wide else (2, 1)), **layout)  # type: ignore[arg-type]
    ax = add_space(sheet, arm, grid[0])
    for each in arm.world.objects:
        draw_object(ax, each, 0.8 * arm.length, placed_surface(each) if each.shape == "mesh" else None)
    for curve, clear in curves:
        for bends, free in zip(*(x[:: max(len(curve) // _DRAWN, 1)] for x in (curve, clear)), strict=True):
            line = shape.position(bends.reshape(-1), arm, np.linspace(0, 1, 60))
            look = {"color": _CLEAR, "zorder": 2.1} if free >= found.margin else {"color": _BLOCKED, "zorder": 2}
            ax.trace(line, linewidth=0.6, **look)
    _chosen(ax, arm, found)
    ax.trace(np.asarray(target)[None], color=TARGET, linestyle="", marker="o", markersize=5, label="target", zorder=5)
    nearest = np.array([found.nearest.place, found.nearest.point])
    ax.trace(nearest, color=BLACK, linewidth=2, label="where it is nearest", zorder=6)
    ax.plot([], [], color=_BLOCKED, label="blocked")
    ax.plot([], [], color=_CLEAR, label="clear")
    ax.plot([], [], **_CHOSEN, label="chosen")
    ax.plot([], [], **_MARGIN, label=f"margin, {1e3 * found.margin:.3g} mm")
    ax.settle(legend=False)
    names = {name: handle for handle, name in zip(*ax.get_legend_handles_labels(), strict=True)}
    sheet.legend(names.values(), names.keys(), loc="outside lower center", ncols=5 if sheet.wide else 3)
    _clear_by_bend(sheet.add_subplot(grid[1]), curves, found)


def _chosen(ax: Space, arm: Arm, found: planning.Avoiding) -> None:
    """Draw the chosen pose: its backbone, and rings as wide as what touches."""
    bend = found.bends.reshape(-1)
    for number, xi in enumerate(section_places(arm, 30)):
        look = section_body(number) | {"linewidth": 2.0, "label": f"chosen, section {number + 1}", "zorder": 4}
        ax.trace(shape.position(bend, arm, xi), **look)
        turn = np.linspace(0, 2 * np.pi, 33)
        ring = arm.contact_radii[number] * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
        for frame in shape.transform(bend, arm, np.linspace(xi[0], xi[-1], arm.sections[number].links + 1)):
            ax.trace(frame[:3, 3] + ring @ frame[:3, :3].T, color=section_hex(number), linewidth=0.5, zorder=3)


def _clear_by_bend(ax: Any, curves: list[tuple[Array, Array]], found: planning.Avoiding) -> None:
    """Draw how clear poses are against how much they bend, as curves where poses follow one another."""
    for bends, clear in curves:
        total = np.degrees(angles_of(bends).sum(axis=-1))
        apart = np.sqrt((np.diff(bends, axis=0) ** 2).sum(axis=(-1, -2)))
        joined = len(bends) > 1 and apart.max() < _JOINED
        dots = {} if joined else {"linestyle": "", "marker": "o", "markersize": 3}
        for kept, colour in ((True, _BLOCKED), (clear >= found.margin, _CLEAR)):
            ax.plot(total, np.where(kept, 1e3 * clear, np.nan), color=colour, linewidth=2, **dots)
    chosen = (float(np.degrees(angles_of(found.bends).sum())), 1e3 * found.clearance)
    ax.plot(*chosen, **_CHOSEN)
    ax.axhline(1e3 * found.margin, **_MARGIN)
    ax.set_xlabel("sum of bend angles [deg]")
    ax.set_ylabel("clearance [mm], below 0 inside")

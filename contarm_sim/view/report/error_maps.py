"""Tip error at rest over the dome, as maps of one colour scale."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.studies.at_rest import Failure, Outcome
from contarm_sim.studies.verdict import MODEL_LIMIT
from contarm_sim.view.colours import error_map
from contarm_sim.view.report.error_field import error_field
from contarm_sim.view.report.errors_by_bend import LEAST
from contarm_sim.view.style import Sheet

FINE = (81, 145)
"""Bend angles and planes that a map is drawn at."""


def draw_error_maps(sheet: Sheet, arm: Arm, outcomes: Sequence[Outcome | Failure]) -> None:
    """Draw tip error over the dome, one polar map a scenario: bend angle outwards, bending plane around.

    All have one logarithmic scale, with a line where the error passes the limit of the verdict on constant curvature.
    A scenario without rest poses has a panel that says so.
    """
    from matplotlib.colors import BoundaryNorm

    cells, scale = _places(sheet, len(outcomes))
    levels = _levels(max((100 * o.comparison.tip_error.max() / arm.length for o in outcomes if isinstance(o, Outcome)),
                         default=1.0))  # fmt: skip
    norm, colours = BoundaryNorm(levels, 256), error_map()
    filled: Any = None
    for index, (outcome, cell) in enumerate(zip(outcomes, cells, strict=True)):
        rests = isinstance(outcome, Outcome)
        ax: Any = sheet.add_subplot(cell, projection="polar" if rests else None)
        ax.set_title(textwrap.fill(outcome.scenario.meaning, 30 if sheet.wide else 22))
        if isinstance(outcome, Failure):
            ax.set_axis_off()
            ax.text(0.5, 0.5, outcome.verdict, ha="center", va="center")
            continue
        largest = float(np.hypot(*outcome.samples.bend.T).max())
        radius, plane = np.meshgrid(np.linspace(0, largest, FINE[0]), np.linspace(0, 2 * np.pi, FINE[1]), indexing="ij")
        shown = np.maximum(error_field(outcome, radius, plane), LEAST)
        radius = np.degrees(radius)
        filled = ax.contourf(plane, radius, shown, levels=levels, norm=norm, cmap=colours)
        ax.contour(plane, radius, shown, levels=[MODEL_LIMIT], colors="black", linewidths=1.2)
        _furnish(ax, float(radius.max()), first=index == 0)
    if filled is not None:
        ax = sheet.add_subplot(scale)
        ax.set_axis_off()
        flat = len(outcomes) == 4 and not sheet.wide
        bar = sheet.colorbar(
            filled, cax=ax.inset_axes((0.0, 0.5, 1.0, 0.3) if flat else (0.4, 0.0, 0.12, 1.0)), format="%g",
            orientation="horizontal" if flat else "vertical", ticks=levels[1::3] if flat else levels,
        )  # fmt: skip
        bar.set_label("tip error vs arc [% of length]")
        (bar.ax.axvline if flat else bar.ax.axhline)(MODEL_LIMIT, color="black", linewidth=1.2)
        bar.minorticks_off()
    sheet.heading("Tip error at rest: bend angle outwards, bending plane around; black line: 1 % of length")


def _places(sheet: Sheet, maps: int) -> tuple[list[Any], Any]:
    """Set the height for four or five maps; return where they stand, and where their scale does."""
    if maps == 4:
        sheet.tall(120 if sheet.wide else 118)
        grid = sheet.add_gridspec(2, 3, width_ratios=[1, 1, 0.5]) if sheet.wide else sheet.add_gridspec(
            3, 2, height_ratios=[1, 1, 0.28])  # fmt: skip
        return [grid[row, column] for row in range(2) for column in range(2)], grid[:, 2] if sheet.wide else grid[2, :]
    sheet.tall(120 if sheet.wide else 158)
    grid = sheet.add_gridspec(2, 3) if sheet.wide else sheet.add_gridspec(3, 2)
    cells = [grid[place] for place in range(6)]
    return cells[:maps], cells[maps]


def _levels(most: float) -> Array:
    """Return edges of colours [% of length]: 1, 2, 5, 10, ..., from the least that is drawn to more than the most."""
    steps = np.array([first * 10.0**power for power in range(-3, 4) for first in (1, 2, 5)])
    steps = steps[steps >= 10 * LEAST]
    return np.concatenate([[LEAST], steps[: int(np.searchsorted(steps, max(most, 1.0), side="left")) + 1]])


def _furnish(ax: Any, largest: float, first: bool) -> None:
    """Draw rings and rays, and name them: rings on the first map only."""
    rings = [ring for ring in (60.0, 120.0) if ring < 0.9 * largest]
    ax.grid(False)
    ax.set_axisbelow(False)
    ax.set_yticks([*rings, largest], [f"{ring:g}°" for ring in rings] * first + [""] * (1 if first else len(rings) + 1))
    ax.set_xticks(np.radians([0, 90, 180, 270]), ["0°", "90°", "180°", "270°"])
    ax.tick_params(axis="x", pad=-1)
    ax.set_rlabel_position(45)
    ax.grid(True, color="white", linewidth=0.5)
    ax.spines["polar"].set_visible(False)

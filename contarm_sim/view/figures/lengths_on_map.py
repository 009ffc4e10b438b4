"""The possible lengths of muscles 2 and 3, and those that a path goes through."""

from __future__ import annotations

from contarm_sim.mechanics import routing
from contarm_sim.model.arm import Arm
from contarm_sim.studies.scenarios import under_loads
from contarm_sim.view.colours import HELD, HELD_EDGE
from contarm_sim.view.figures.common import BROAD, THIN, OwnPath, called, followed
from contarm_sim.view.report.map import draw_possibility, map_of
from contarm_sim.view.stance import stance
from contarm_sim.view.style import Sheet
from contarm_sim.view.trim import trim

MM = 1e3


def possibility(sheet: Sheet, arm: Arm) -> None:
    """Draw the pressure-limited possibility map inside the paper's ellipse, free and loaded."""
    draw_possibility(sheet, under_loads(arm))


def lengths_on_map(sheet: Sheet, arm: Arm, own: OwnPath | None = None) -> None:
    """Draw a path's lengths over the ellipse, the bends that pressure holds shaded."""
    samples, highest, found = followed(arm, own), arm.pneumatics.max_pressure, map_of(arm)
    sheet.heading(f"Lengths along {called(own)} inside those that are possible ({stance(arm)})")
    ax = sheet.subplots()
    found.fill(ax, highest, HELD)
    found.edge(ax, highest, colors=HELD_EDGE, linewidths=0.8)
    ax.fill([], [], facecolor=HELD, edgecolor=HELD_EDGE, label=f"held by up to {highest / 1e3:.0f} kPa")
    found.frame(ax)
    walked, analytic = MM * (samples.muscle_lengths - arm.length), MM * routing.arc_deltas(samples.bend, arm)
    ax.plot(walked[:, 1], walked[:, 2], **BROAD)
    ax.plot(analytic[:, 1], analytic[:, 2], **THIN | {"label": "arc (paper)"})
    ax.set_xlabel("length change of muscle 2 [mm]")
    ax.set_ylabel("length change of muscle 3 [mm]")
    look = {"loc": "upper left", "bbox_to_anchor": (1.02, 1.0)} if sheet.wide else {"loc": "lower left", "ncols": 1,
            "bbox_to_anchor": (-0.15, 1.0)}  # fmt: skip
    ax.legend(**look)
    trim(sheet, 92.0 if sheet.wide else 125.0)

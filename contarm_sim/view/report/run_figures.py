"""The figures of a run's path and of its muscles."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import each, slices
from contarm_sim.mechanics.routing import arc_deltas
from contarm_sim.model.colours import muscle_hex
from contarm_sim.model.pneumatic_law import PneumaticLaw
from contarm_sim.results.compare import Comparison
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.colours import LIMIT, SIMULATED, TARGET
from contarm_sim.view.outlines import poses_at
from contarm_sim.view.sections import backbone_lines, dashes
from contarm_sim.view.space import add_space
from contarm_sim.view.stance import stance
from contarm_sim.view.style import Sheet
from contarm_sim.view.trim import trim

ROOM = 1.12
"""Pressures are drawn to so many times the highest that there is."""


def draw_path(sheet: Sheet, samples: Trajectory, comparison: Comparison) -> None:
    """Draw target and simulated tips in the world, with the reachable tips behind and the backbone at the end.

    Of one section these are the dome; of several their hull is drawn.
    """
    arm = samples.arm
    ax = add_space(sheet, arm)
    ax.reachable()
    for name, colour, stations in backbone_lines(samples.stations[-1], arm):
        ax.trace(stations, color=colour, linewidth=2.2, marker="o", markersize=2.4, label=f"{name}, last sample")
    ax.trace(samples.target, color=TARGET, linewidth=1.4, linestyle=(0, (4, 2)), label="target")
    ax.trace(comparison.simulated_tip, color=SIMULATED, linewidth=1.4, label="simulated tip")
    ax.objects(poses_at(samples, len(samples) - 1))
    ax.settle()
    where = "inside the hull" if len(arm.sections) > 1 else "on the dome"
    sheet.heading(f"Path of the tip {where} of reachable tips ({stance(arm)})")
    trim(sheet, 110)


def draw_muscles(sheet: Sheet, samples: Trajectory) -> None:
    """Draw muscle lengths, how far they are off the arc's, tensions and, where there are any, pressures over time.

    Each section has a column.
    """
    arm, groups = samples.arm, samples.arm.groups
    off = samples.muscle_lengths - each(arm, lambda group: group.length)
    pneumatic = any(isinstance(group.law, PneumaticLaw) for group in groups)
    kinds = ["length\nchange [mm]", "off the\narc's [mm]", "tension [N]", *(["pressure\nneeded [kPa]"] * pneumatic)]
    heights = [34, 24, 30, *([34] * pneumatic)]
    sheet.tall(sum(heights) + 34)
    panels = sheet.subplots(len(kinds), len(groups), sharex=True, sharey="row", squeeze=False, height_ratios=heights)
    rows = (1e3 * off, 1e3 * (off - arc_deltas(samples.bend, arm)), samples.muscle_tensions)
    for column, (group, own) in enumerate(zip(groups, slices(arm), strict=True)):
        for ax, values in zip(panels[:, column], rows, strict=False):
            _lines(ax, samples.time, values[:, own])
        if isinstance(group.law, PneumaticLaw):
            _pressures(panels[3, column], samples.time, samples.pressure[:, own], group.law)
        panels[2, column].axhline(group.law.min_tension, color=LIMIT, linewidth=0.9, linestyle="--")
        panels[-1, column].set_xlabel("time [s]")
        if len(arm.sections) > 1:
            named = "section " if sheet.wide or len(groups) <= 3 else ""
            panels[0, column].set_title(f"{named}{group.section + 1}")
    for ax, words in zip(panels[:, 0], kinds, strict=True):
        ax.set_ylabel(words)
    panels[2, 0].set_ylim(bottom=min(0.0, float(samples.muscle_tensions.min())))
    _name_limits(panels, [group.law for group in groups])
    sheet.get_layout_engine().set(h_pad=0.04)  # type: ignore[union-attr, call-arg]
    sheet.align_ylabels(panels[:, 0])
    most = max((group.routing.count for group in groups), default=0)
    for i in range(most):
        panels[0, 0].plot([], [], color=muscle_hex(i), linestyle=dashes(i), label=f"muscle {i + 1}")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    if pneumatic and np.isinf(samples.pressure).any():
        handles.append(panels[3, 0].plot([], [], "k^", linestyle="none")[0])
        labels.append("more than any pressure")
    sheet.legend(
        handles, labels, loc="outside lower center", ncols=len(labels) if sheet.wide else 3 - (len(labels) > most)
    )
    sheet.heading("Muscles: lengths beside those of the arc, tensions" + (", pressures that they need" * pneumatic))


def _lines(ax: Any, time: Array, values: Array) -> None:
    """Draw a line a muscle through values of shape (T, n)."""
    for i in range(values.shape[1]):
        ax.plot(time, values[:, i], color=muscle_hex(i), linestyle=dashes(i))


def _pressures(ax: Any, time: Array, pressure: Array, law: PneumaticLaw) -> None:
    """Draw pressures [Pa], shape (T, n), their limits, and where no pressure would do a mark at the upper edge."""
    never = np.isinf(pressure)
    _lines(ax, time, 1e-3 * np.where(never, np.nan, pressure))
    for limit in law.pressure_limits:
        ax.axhline(1e-3 * limit, color=LIMIT, linewidth=0.9, linestyle="--")
    most = float(np.max(pressure, initial=law.pressure_limits[1], where=~never & np.isfinite(pressure)))
    top = max(ax.get_ylim()[1] if ax.get_ylim()[0] == 0 else 0.0, 1e-3 * ROOM * most)
    ax.set_ylim(0, top)
    for i in range(pressure.shape[1]):
        if len(times := time[never[:, i]][:: max(1, len(time) // 50)]):
            ax.plot(times, np.full(len(times), 1), "^", color=muscle_hex(i), transform=ax.get_xaxis_transform(),
                    clip_on=False)  # fmt: skip


def _name_limits(panels: Any, laws: list[Any]) -> None:
    """Write what the limits are on the right of panels; their numbers where all sections have the same."""

    def name(ax: Any, words: str, at: float, unit: str, every: set[float]) -> None:
        said = f"{words}:\n{at:g} {unit}" if len(every) == 1 else words
        ax.annotate(said, (1, at), xycoords=("axes fraction", "data"), xytext=(3, 0), textcoords="offset points",
                    va="center")  # fmt: skip

    name(panels[2, -1], "least", laws[-1].min_tension, "N", {law.min_tension for law in laws})
    pressed = [column for column, law in enumerate(laws) if isinstance(law, PneumaticLaw)]
    for i, words in enumerate(("lowest", "highest") if pressed else ()):
        every = [1e-3 * laws[column].pressure_limits[i] for column in pressed]
        name(panels[3, pressed[-1]], words, every[-1], "kPa", set(every))

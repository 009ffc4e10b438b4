"""Which cases of a sweep failed: how many, where among the parameters, and why."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.sweeps.statuses import OK
from contarm_sim.view.colours import BLUE, ORANGE, PURPLE, RED, SKY, TARGET
from contarm_sim.view.report.sweeps.columns import Column, bins_for, by_effect, sorted_into
from contarm_sim.view.report.sweeps.heat_maps import draw_share_map
from contarm_sim.view.report.sweeps.ticks import name_places
from contarm_sim.view.style import Sheet

_COLOURS = (RED, ORANGE, PURPLE, BLUE, SKY)
_HATCHES = ("", "////", "....", "xxxx", "----", "\\\\\\\\")
"""Reasons differ in both, so that they differ in grey; one more of these, so that thirty pairs differ."""

_AT_MOST = 6
"""Parameters that have bars: those of the largest effect on failing."""


def draw_failures(sheet: Sheet, columns: list[Column], status: NDArray[Any]) -> None:
    """Draw the shares of cases that failed by each parameter, stacked by reason, and a map over the two that matter.

    Args:
        columns: the parameters that vary.
        status: of each case, shape (K,).
    """
    failed = status != OK
    reasons = [str(reason) for reason in np.unique(status[failed])]
    ranked = by_effect(columns, failed.astype(float)) or columns
    drawn, mapped = ranked[:_AT_MOST], len(ranked) > 1
    beside = min(2 if mapped or not sheet.wide else 3, len(drawn))
    rows = -(-len(drawn) // beside)
    whole: Any = sheet.add_gridspec(1, 2, width_ratios=[1, beside]) if sheet.wide else sheet.add_gridspec(
        2, 1, height_ratios=[1.7, rows])  # fmt: skip
    if mapped:
        sheet.tall(max(30 + 40 * rows, 92) if sheet.wide else 80 + 34 * rows)
        draw_share_map(sheet, sheet.add_subplot(whole[0]), ranked, failed)
    else:
        sheet.tall(80)
    grid = (whole[1] if mapped else sheet.add_gridspec(1, 1)[0]).subgridspec(rows, beside)
    bars = [sheet.add_subplot(grid[place]) for place in range(len(drawn))]
    for place, (ax, column) in enumerate(zip(bars, drawn, strict=True)):
        _bars(ax, column, status, reasons, (80 if sheet.wide else 66) / beside)
        if place % beside == 0:
            ax.set_ylabel("failed [%]")
    most = max(ax.get_ylim()[1] for ax in bars)
    for ax in bars:
        ax.set_ylim(0, min(most, 100))
    handles = bars[0].get_legend_handles_labels()[0]
    sheet.legend(handles, reasons, loc="outside lower center", ncols=3 if sheet.wide else 2)
    left = len(ranked) - len(drawn)
    more = f"; {left} more parameters have less effect" if left else ""
    sheet.heading(f"{int(failed.sum())} of {len(failed)} cases failed: where, and why{more}")


def _bars(ax: Any, column: Column, status: NDArray[Any], reasons: list[str], width: float) -> None:
    """Draw shares by levels or bins of a parameter, in so many millimetres: side by side where numbers go on."""
    groups = sorted_into(column, min(bins_for(len(status), 1), 10))
    total = np.bincount(groups.place, minlength=groups.count)
    base, places = np.zeros(groups.count), np.arange(groups.count)
    for number, reason in enumerate(reasons):
        share = 100 * np.bincount(groups.place[status == reason], minlength=groups.count) / np.maximum(total, 1)
        bars = ax.bar(places, share, bottom=base, color=_COLOURS[number % len(_COLOURS)], label=reason,
                      width=0.8 if column.spaced is None and not groups.binned else 1.0,
                      hatch=_HATCHES[number % len(_HATCHES)], edgecolor=TARGET, linewidth=0.3)  # fmt: skip
        for bar in bars:
            bar.set_hatch_linewidth(0.4)
        base = base + share
    ax.set_xlim(-0.6, groups.count - 0.4)
    name_places(ax.xaxis, column, groups, width)
    ax.set_xlabel(column.wrapped(int(0.5 * width)))
    ax.grid(axis="x", visible=False)

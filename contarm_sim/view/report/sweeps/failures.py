"""Which cases of a sweep failed: how many, where among the parameters, and why."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.sweeps.statuses import OK
from contarm_sim.view.colours import BLUE, HELD, ORANGE, PURPLE, RED, SKY
from contarm_sim.view.report.sweeps.columns import Column, bins_for, by_effect, name_places, sorted_into
from contarm_sim.view.report.sweeps.heat_maps import draw_share_map
from contarm_sim.view.style import Sheet

_COLOURS = (RED, ORANGE, PURPLE, BLUE, SKY)

_AT_MOST, _IN_COLUMN = 6, 3
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
    drawn, mapped = ranked[: _AT_MOST if sheet.wide else _IN_COLUMN], len(ranked) > 1
    beside = min(2 if mapped else 3, len(drawn)) if sheet.wide else 1
    rows = -(-len(drawn) // beside)
    whole: Any = sheet.add_gridspec(1, 2, width_ratios=[1, beside]) if sheet.wide else sheet.add_gridspec(
        2, 1, height_ratios=[1.7, rows])  # fmt: skip
    if mapped:
        sheet.tall(max(34 + 44 * rows, 92) if sheet.wide else 98 + 40 * rows)
        draw_share_map(sheet, sheet.add_subplot(whole[0]), ranked, failed)
    else:
        sheet.tall(80)
    grid = (whole[1] if mapped else sheet.add_gridspec(1, 1)[0]).subgridspec(rows, beside)
    bars = [sheet.add_subplot(grid[place]) for place in range(len(drawn))]
    for place, (ax, column) in enumerate(zip(bars, drawn, strict=True)):
        _bars(ax, column, status, reasons, (110 if sheet.wide else 66) // beside)
        if place % beside == 0:
            ax.set_ylabel("failed [%]")
    most = max(ax.get_ylim()[1] for ax in bars)
    for ax in bars:
        ax.set_ylim(0, min(most, 100))
    handles = bars[0].get_legend_handles_labels()[0]
    sheet.legend(handles, reasons, loc="outside lower center", ncols=3 if sheet.wide else 2)
    sheet.heading(f"{int(failed.sum())} of {len(failed)} cases failed: where, and why")


def _bars(ax: Any, column: Column, status: NDArray[Any], reasons: list[str], width: float) -> None:
    """Draw shares by levels or bins of a parameter, in so many millimetres."""
    groups = sorted_into(column, min(bins_for(len(status), 1), 10))
    total = np.bincount(groups.place, minlength=groups.count)
    base, places = np.zeros(groups.count), np.arange(groups.count)
    for number, reason in enumerate(reasons):
        share = 100 * np.bincount(groups.place[status == reason], minlength=groups.count) / np.maximum(total, 1)
        ax.bar(places, share, bottom=base, color=_COLOURS[number % len(_COLOURS)], width=0.9, label=reason,
               hatch="//" * (number // len(_COLOURS)), edgecolor=HELD, linewidth=0.3)  # fmt: skip
        base = base + share
    ax.set_xlim(-0.6, groups.count - 0.4)
    name_places(ax.xaxis, groups, int(width / (2.0 * (max(map(len, groups.names)) + 1))))
    ax.set_xlabel(column.wrapped(int(0.5 * width)))
    ax.grid(axis="x", visible=False)

"""Which cases of a sweep failed: how many, where among the parameters, and why."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.view.colours import BLUE, HELD, ORANGE, PURPLE, RED, SKY
from contarm_sim.view.report.sweeps.columns import Column, bins_for, by_effect, name_places, sorted_into
from contarm_sim.view.report.sweeps.heat_maps import draw_share_map
from contarm_sim.view.style import Sheet

DONE = "ok"
"""The status of a case that has what was asked for."""

_COLOURS = (RED, ORANGE, PURPLE, BLUE, SKY)

_AT_MOST = 5
"""Parameters that have bars: those of the largest effect on failing."""


def draw_failures(sheet: Sheet, columns: list[Column], status: NDArray[Any]) -> None:
    """Draw the shares of cases that failed by each parameter, stacked by reason, and a map over the two that matter.

    Args:
        columns: the parameters that vary.
        status: of each case, shape (K,).
    """
    failed = status != DONE
    reasons = [str(reason) for reason in np.unique(status[failed])]
    ranked = by_effect(columns, failed.astype(float)) or columns
    drawn, mapped = ranked[:_AT_MOST], len(ranked) > 1
    panels = len(drawn) + mapped
    beside = min(panels, 3 if sheet.wide else 1)
    rows = -(-panels // beside)
    sheet.tall(30 + 50 * rows if sheet.wide else 34 + 36 * rows)
    axes: Any = sheet.subplots(rows, beside, squeeze=False).ravel()
    if mapped:
        draw_share_map(sheet, axes[0], ranked, failed)
    bars = axes[mapped:]
    for ax, column in zip(bars, drawn, strict=False):
        _bars(ax, column, status, reasons, sheet.wide, beside)
    for ax in bars[len(drawn) :]:
        ax.set_axis_off()
    most = max(ax.get_ylim()[1] for ax in bars[: len(drawn)])
    for number, ax in enumerate(bars[: len(drawn)]):
        ax.set_ylim(0, min(1.08 * most, 100))
        if (number + mapped) % beside == 0 or (number == 0):
            ax.set_ylabel("failed [%]")
    handles = bars[0].get_legend_handles_labels()[0]
    sheet.legend(handles, reasons, loc="outside lower center", ncols=3 if sheet.wide else 1)
    count, total = int(failed.sum()), len(failed)
    sheet.heading(f"{count} of {total} cases failed: where, and why")


def _bars(ax: Any, column: Column, status: NDArray[Any], reasons: list[str], wide: bool, beside: int) -> None:
    groups = sorted_into(column, min(bins_for(len(status), 1), 10))
    total = np.bincount(groups.place, minlength=groups.count)
    base, places = np.zeros(groups.count), np.arange(groups.count)
    for number, reason in enumerate(reasons):
        share = 100 * np.bincount(groups.place[status == reason], minlength=groups.count) / np.maximum(total, 1)
        ax.bar(places, share, bottom=base, color=_COLOURS[number % len(_COLOURS)], width=0.9, label=reason,
               hatch="/" * (number // len(_COLOURS)), edgecolor=HELD, linewidth=0.3)  # fmt: skip
        base = base + share
    ax.set_xlim(-0.6, groups.count - 0.4)
    letters = max(map(len, groups.names)) + 1
    name_places(ax.xaxis, groups, int((150 / beside if wide else 62) / (1.9 * letters)) or 1)
    ax.set_xlabel(column.label)
    ax.grid(axis="x", visible=False)

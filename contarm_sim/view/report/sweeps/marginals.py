"""A quantity against each parameter alone: its median and spread over all the others, and the cases themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.colours import BLUE, ERROR, NOTE, SKY
from contarm_sim.view.report.sweeps.columns import Column, Sorted, by_effect, sorted_into
from contarm_sim.view.report.sweeps.matched import matched
from contarm_sim.view.report.sweeps.ticks import name_numbers, name_places
from contarm_sim.view.style import INCH, Sheet

_BAND = (0.1, 0.9)
"""Quantiles that a band is between."""

_POINTS = 1500
"""At most so many cases are drawn themselves."""

_AT_MOST = 8
"""More parameters are not drawn: those of the largest effect are."""

_FEW, _MANY_BINS, _LISTED = 40, 10, 8
"""Cases of a bin (a third suffices for a median); most bins; most listed numbers that stand apart."""


def draw_marginals(sheet: Sheet, columns: list[Column], value: Column, grid: bool) -> None:
    """Draw a quantity against each parameter that varies, those of the largest effect first.

    Of a grid in which cases failed, only those settings of the other parameters count that have a value at every level.

    Args:
        columns: the parameters that vary.
        value: the quantity, NaN where the case failed.
        grid: whether the design is a grid.
    """
    ranked = by_effect(columns, np.log(value.shown) if value.log else value.shown) or columns
    drawn = ranked[:_AT_MOST]
    beside = min(len(drawn), 3 if sheet.wide else 1 + (len(drawn) > 3))
    rows = -(-len(drawn) // beside)
    sheet.tall(26 + (56 if rows == 1 else 47) * rows)
    panels: Any = sheet.subplots(rows, beside, sharey=True, squeeze=False)
    sheet.get_layout_engine().set(hspace=0.05)  # type: ignore[union-attr, call-arg]
    known, compared = np.isfinite(value.shown), True
    for ax, column in zip(panels.flat, drawn, strict=False):
        kept = known
        if grid and not known.all():
            found = matched(column, [each for each in columns if each is not column], known)
            ax.set_title(f"{found.settings} of {found.tried} settings", color=NOTE)
            kept, compared = found.rows, False
        _panel(ax, column, value.shown, kept, known, INCH * sheet.get_figwidth() / beside - 12)
    for ax in panels.flat[len(drawn) :]:
        ax.set_axis_off()
    if value.log:
        panels[0, 0].set_yscale("log")
        name_numbers(panels[0, 0].yaxis, value.shown[known], True, 6)
    for ax in panels[:, 0]:
        ax.set_ylabel(value.wrapped(26))
    handles = {
        label: handle for ax in panels.flat for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    sheet.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3 if sheet.wide else 2)
    left = len(ranked) - len(drawn)
    more = f"; {left} more have less effect" if left else ""
    said = "" if compared else ", in settings of the others in which no case failed"
    if not grid and not known.all():
        said = f": {int((~known).sum())} of {len(known)} cases failed, and are not in it"
    sheet.heading(f"{value.words} by each parameter{said}{more}")


def _panel(ax: Any, column: Column, values: Array, kept: NDArray[Any], known: NDArray[Any], width: float) -> None:
    """Draw one parameter, in so many millimetres: medians and bands of the cases that are kept, or cases alone."""
    ax.set_xlabel(column.wrapped(int(width / 1.8)))
    ax.use_sticky_edges = False
    if not known.any():
        return
    groups = sorted_into(column, int(np.clip(kept.sum() // _FEW, 1, _MANY_BINS)))
    apart = not groups.binned and (not column.numeric or groups.count <= (_LISTED if column.spaced is None else 3))
    shown = kept if kept.any() else known
    thin = np.flatnonzero(shown)[:: -(-int(shown.sum()) // _POINTS)]
    aside = 0.22 * np.sin(2.399963 * np.arange(len(thin)))  # the golden angle: evenly, and the same every time
    across = groups.place[thin] + aside if apart else column.shown[thin]
    ax.plot(across, values[thin], ".", color=BLUE, markersize=2.5, alpha=0.4, label="one case", rasterized=True)
    filled, low, middle, high = _spread(groups, values, kept)
    band = {"color": SKY, "alpha": 0.4, "linewidth": 0, "zorder": 0.5, "label": "10th to 90th percentile"}
    if apart:
        ax.bar(filled, high - low, bottom=low, width=0.7, **band)
        ax.hlines(middle, filled - 0.35, filled + 0.35, color=ERROR, linewidth=1.4, label="median")
        ax.set_xlim(-0.6, groups.count - 0.4)
        name_places(ax.xaxis, column, groups, width)
        return
    if len(filled) > 2 or not groups.binned:
        centres = groups.centres[filled]
        ax.fill_between(centres, low, high, **band)
        ax.plot(centres, middle, "-", color=ERROR, label="median")
    if column.log:
        ax.set_xscale("log")
    name_numbers(ax.xaxis, column.shown, column.log, max(int(width / 10), 2))


def _spread(groups: Sorted, values: Array, kept: NDArray[Any]) -> tuple[NDArray[Any], Array, Array, Array]:
    """Return which levels, or bins with cases enough, there are, and the quantiles and medians of these."""
    size = np.bincount(groups.place[kept], minlength=groups.count)
    filled = np.flatnonzero(size >= (_FEW // 3 if groups.binned else 1))
    found = np.array([np.quantile(values[kept & (groups.place == k)], (_BAND[0], 0.5, _BAND[1])) for k in filled])
    low, middle, high = found.reshape(-1, 3).T
    return filled, low, middle, high

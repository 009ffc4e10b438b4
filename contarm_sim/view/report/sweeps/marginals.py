"""A quantity against each parameter alone: its median and spread over all the others, or the cases themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.colours import BLUE, ERROR, HELD
from contarm_sim.view.report.sweeps.columns import Column, Sorted, bins_for, by_effect, name_places, sorted_into
from contarm_sim.view.style import Sheet

_BAND = (0.1, 0.9)
"""Quantiles that a band is between."""

_POINTS = 1500
"""At most so many cases are drawn themselves."""

_AT_MOST = 8
"""More parameters are not drawn: those of the largest effect are."""


def draw_marginals(sheet: Sheet, columns: list[Column], value: Column) -> None:
    """Draw a quantity against each parameter that varies, those of the largest effect first.

    Lines are medians of levels or bins, bands are from the 10th to the 90th percentile; marks are cases, where a
    design has none at the same place. Texts have a strip each.
    """
    ranked = by_effect(columns, np.log(value.shown) if value.log else value.shown) or columns
    drawn = ranked[:_AT_MOST]
    beside = min(len(drawn), 3 if sheet.wide else 1 + (len(drawn) > 3))
    rows = -(-len(drawn) // beside)
    sheet.tall(20 + (56 if rows == 1 else 47) * rows)
    panels: Any = sheet.subplots(rows, beside, sharey=True, squeeze=False)
    bands = False
    for ax, column in zip(panels.flat, drawn, strict=False):
        bands |= _panel(ax, column, value, sheet, beside)
    for ax in panels.flat[len(drawn) :]:
        ax.set_axis_off()
    if value.log:
        panels[0, 0].set_yscale("log")
        _name_few(panels[0, 0].yaxis, value.shown[np.isfinite(value.shown)])
    for ax in panels[:, 0]:
        ax.set_ylabel(value.wrapped(26))
    left = len(ranked) - len(drawn)
    more = f"; {left} more have less effect" if left else ""
    band = ", in a band from the 10th to the 90th percentile" if bands else ""
    sheet.heading(f"{value.label} by each parameter, whatever the others are: median{band}{more}")


def _panel(ax: Any, column: Column, value: Column, sheet: Sheet, beside: int) -> bool:
    """Draw one parameter; return whether there is a band."""
    known = np.isfinite(value.shown)
    chosen, values = column.chosen(known), value.shown[known]
    ax.set_xlabel(column.wrapped((84 if sheet.wide else 40) // beside))
    if len(values) == 0:
        return False
    groups = sorted_into(chosen, bins_for(len(values), 1))
    low, middle, high, filled = _spread(groups, values)
    if not column.numeric:
        _strips(ax, groups, values, middle)
        name_places(ax.xaxis, groups, groups.count)
        return False
    if groups.binned:
        thin = np.linspace(0, len(values) - 1, min(len(values), _POINTS)).astype(int)
        ax.plot(chosen.shown[thin], values[thin], ".", color=BLUE, markersize=2, alpha=0.35, rasterized=True)
    centres = groups.centres[filled]
    ax.fill_between(centres, low, high, color=HELD, linewidth=0, zorder=0.5)
    ax.plot(centres, middle, "-" if groups.binned else "o-", color=ERROR)
    if column.log:
        ax.set_xscale("log")
        _name_few(ax.xaxis, chosen.shown)
    else:
        ax.xaxis.set_major_locator(MaxNLocator(3 if beside > 1 and not sheet.wide else 4))
    return bool(np.any(high > low))


def _spread(groups: Sorted, values: Array) -> tuple[Array, Array, Array, Array]:
    """Return quantiles and medians of the levels or bins that hold any cases, and which these are."""
    filled = np.unique(groups.place)
    found = np.array([np.quantile(values[groups.place == k], (_BAND[0], 0.5, _BAND[1])) for k in filled])
    return found[:, 0], found[:, 1], found[:, 2], filled


def _strips(ax: Any, groups: Sorted, values: Array, middle: Array) -> None:
    """Draw cases of a text's levels beside each other, and their medians."""
    thin = np.linspace(0, len(values) - 1, min(len(values), _POINTS)).astype(int)
    aside = 0.22 * np.sin(2.399963 * np.arange(len(thin)))  # the golden angle: evenly, and the same every time
    ax.plot(groups.place[thin] + aside, values[thin], ".", color=BLUE, markersize=2.5, alpha=0.5, rasterized=True)
    for k, median in zip(np.unique(groups.place), middle, strict=True):
        ax.plot([k - 0.3, k + 0.3], [median, median], color=ERROR, linewidth=1.6)
    ax.set_xlim(-0.6, groups.count - 0.4)


def _name_few(axis: Any, shown: Array) -> None:
    """Name decades of a logarithmic axis; of one without two of them 1, 2 and 5."""
    wide = np.log10(shown.max() / shown.min())
    if wide < 1.5:
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if wide > 0.4 else (1, 1.5, 2, 3, 5, 7)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())

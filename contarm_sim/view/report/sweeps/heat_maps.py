"""A quantity over two parameters, as colours of cells: medians of the cases in them; the others stand at levels."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.colours import FAINT, NOTE, error_map, failure_map, value_map
from contarm_sim.view.report.sweeps.columns import Column, Sorted, axes_of, bins_for, by_effect, sorted_into
from contarm_sim.view.report.sweeps.ticks import name_numbers, name_places
from contarm_sim.view.style import INCH, Sheet

_PANELS = 3
"""Most levels of a third parameter that have a map each."""


class Slice(NamedTuple):
    """Some rows of a table, and what they have in common."""

    title: str
    rows: NDArray[Any]


def slices(others: Sequence[Column], values: Array, grid: bool) -> list[Slice]:
    """Return the rows that have a map each: levels of the first of the other parameters, the rest at one level.

    That is the level with the most values, shape (K,), not NaN; of several, the one that was listed first. None where
    the design is no grid: all rows belong together then.
    """
    if not others or not grid:
        return []
    rows, said = np.ones(len(values), dtype=bool), []
    for column in others[1:]:
        group = sorted_into(column, 1)
        known = np.bincount(group.place[rows & np.isfinite(values)], minlength=group.count)
        level = max(dict.fromkeys(group.place.tolist()), key=lambda place: known[place])
        rows &= group.place == level
        said.append(_at(column, group.names[level]))
    first = sorted_into(others[0], 1)
    levels = np.unique(np.linspace(0, first.count - 1, min(_PANELS, first.count)).round().astype(int))
    common = f", {', '.join(said)}" if said else ""
    return [Slice(f"{_at(others[0], first.names[k])}{common}", rows & (first.place == k)) for k in levels]


def _at(column: Column, level: str) -> str:
    """Return a level in words: payload 50 g."""
    return f"{column.words} {level}{'' if column.read_unit == '-' else f' {column.read_unit}'}"


def draw_heat_map(sheet: Sheet, columns: list[Column], value: Column, failed: NDArray[Any], grid: bool) -> None:
    """Draw a quantity over the two parameters of the largest effect on it.

    Args:
        columns: the parameters that vary, two or more.
        value: the quantity.
        failed: rows without it because the case failed, shape (K,).
        grid: whether the design is a grid, so that others can stand at levels.
    """
    from matplotlib.colors import LogNorm

    scaled = np.log(value.shown) if value.log else value.shown
    x, y, others = axes_of(columns, scaled)
    every = Slice("", np.ones(len(failed), dtype=bool))
    parts = [
        part
        for part in slices(by_effect(others, scaled), value.shown, grid)
        if (part.rows & ~np.isnan(value.shown)).any()
    ] or [every]
    bins = bins_for(len(failed), 2)
    across, upwards = sorted_into(x, bins), sorted_into(y, bins)
    cells = [_medians(across, upwards, value.shown, part.rows) for part in parts]
    lost = [_any(across, upwards, failed & part.rows) & np.isnan(cell) for part, cell in zip(parts, cells, strict=True)]
    norm = scale_of(value, np.concatenate([cell[np.isfinite(cell)] for cell in cells]))
    count = len(parts)
    sheet.tall((96 if count == 1 else 80) if sheet.wide else (44 + 52 * count if count > 1 else 92))
    panels: Any = sheet.subplots(*((1, count) if sheet.wide else (count, 1)), squeeze=False, sharex=True, sharey=True)
    drawn: Any = None
    for ax, part, medians, gone in zip(panels.flat, parts, cells, lost, strict=True):
        drawn = _cells(ax, medians, norm, map_of(value))
        _cross_out(ax, gone)
        ax.set_title(textwrap.fill(part.title, 90 // count if sheet.wide else 44))
    _furnish(sheet, panels, (x, across), (y, upwards))
    bar = sheet.colorbar(drawn, ax=panels if sheet.wide else panels[-1, 0], aspect=30,
                         orientation="vertical" if sheet.wide else "horizontal")  # fmt: skip
    bar.set_label(value.label if sheet.wide else value.wrapped(40))
    name_numbers(bar.ax.yaxis if sheet.wide else bar.ax.xaxis, np.array([norm.vmin, norm.vmax]),
                 isinstance(norm, LogNorm), 8)  # fmt: skip
    cell = across.place * upwards.count + upwards.place
    several = any(np.bincount(cell[part.rows]).max() > 1 for part in parts)
    median = ", median of the cases in each cell" if several else ""
    crossed = "; crossed out: every case there failed" if any(gone.any() for gone in lost) else ""
    blank = any((np.isnan(medians) & ~gone).any() for medians, gone in zip(cells, lost, strict=True))
    sheet.heading(f"{value.label}{median}{crossed}{'; white: no case' if blank else ''}")


def draw_share_map(sheet: Sheet, ax: Any, columns: list[Column], failed: NDArray[Any]) -> None:
    """Draw which share of the cases failed, over the two parameters of the largest effect on that."""
    from matplotlib.colors import Normalize

    two = by_effect(columns, failed.astype(float))
    x, y = sorted((two if len(two) > 1 else columns)[:2], key=lambda column: not column.numeric)
    bins = bins_for(len(failed), 2)
    across, upwards = sorted_into(x, bins), sorted_into(y, bins)
    total = np.zeros((across.count, upwards.count))
    bad = np.zeros_like(total)
    np.add.at(total, (across.place, upwards.place), 1)
    np.add.at(bad, (across.place, upwards.place), failed)
    with np.errstate(invalid="ignore"):
        share = 100 * bad / np.where(total > 0, total, np.nan)
    drawn = _cells(ax, share, Normalize(0, 100), failure_map())
    _furnish(sheet, np.array([[ax]]), (x, across), (y, upwards), 0.4 if sheet.wide else 0.85)
    sheet.colorbar(drawn, ax=ax, orientation="horizontal", aspect=30).set_label("cases that failed [%]")


def map_of(value: Column) -> Any:
    """Return the colours of a quantity: errors have theirs in all figures."""
    return error_map() if "error" in value.name else value_map()


def scale_of(value: Column, found: Array) -> Any:
    """Return the scale of colours from the least to the largest of what was found."""
    from matplotlib.colors import LogNorm, Normalize

    low, high = (float(found.min()), float(found.max())) if len(found) else (0.1, 1.0)
    if value.log and high > 1.5 * low:
        return LogNorm(low, high)
    return Normalize(low, high if high > low else low + max(abs(low), 1e-9))


def _cells(ax: Any, cell: Array, norm: Any, colours: Any) -> Any:
    """Draw cells without gaps in a frame: pale ones are seen as part of the map."""
    edges = (np.arange(size + 1) - 0.5 for size in cell.shape)
    ax.grid(False)
    ax.spines[:].set_visible(True)
    return ax.pcolormesh(*edges, np.ma.masked_invalid(cell.T), cmap=colours, norm=norm, edgecolor="face", linewidth=0.2)


def _cross_out(ax: Any, gone: NDArray[Any]) -> None:
    places = np.argwhere(gone)
    if len(places):
        for i, j in places:
            ax.fill(
                [i - 0.5, i + 0.5, i + 0.5, i - 0.5], [j - 0.5, j - 0.5, j + 0.5, j + 0.5], color=FAINT, linewidth=0
            )
        ax.plot(*places.T, "x", color=NOTE, markersize=3.5, markeredgewidth=0.8)


def _furnish(sheet: Sheet, panels: Any, across: tuple[Column, Sorted], upwards: tuple[Column, Sorted],
             share: float = 0.85) -> None:  # fmt: skip
    """Name both axes, as many of their levels as there is room for."""
    width = share * INCH * sheet.get_figwidth() / panels.shape[1] - 8
    name_places(panels[0, 0].xaxis, *across, width)
    name_places(panels[0, 0].yaxis, *upwards, INCH * sheet.get_figheight() / panels.shape[0] - 24)
    for ax in panels[-1]:
        ax.set_xlabel(across[0].wrapped(max(int(0.6 * width), 12)))
    for ax in panels[:, 0]:
        ax.set_ylabel(upwards[0].wrapped(30))


def _medians(across: Sorted, upwards: Sorted, values: Array, rows: NDArray[Any]) -> Array:
    """Return medians of values by cell, shape (across, upwards); NaN where there are none."""
    out = np.full((across.count, upwards.count), np.nan)
    known = rows & np.isfinite(values)
    if not known.any():
        return out
    cell = across.place * upwards.count + upwards.place
    order = np.argsort(cell[known], kind="stable")
    numbers, firsts = np.unique(cell[known][order], return_index=True)
    for number, group in zip(numbers, np.split(values[known][order], firsts[1:]), strict=True):
        out.flat[number] = np.median(group)
    return out


def _any(across: Sorted, upwards: Sorted, rows: NDArray[Any]) -> NDArray[Any]:
    out = np.zeros((across.count, upwards.count), dtype=bool)
    out[across.place[rows], upwards.place[rows]] = True
    return out

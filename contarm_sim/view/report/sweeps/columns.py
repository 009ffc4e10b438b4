"""Columns of a sweep's table as they are drawn: in units that people read, sorted into levels or bins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array

LEVELS = 24
"""A parameter with more different values is sorted into bins."""

_READ = {"m": (1e3, "mm"), "rad": (180 / np.pi, "deg"), "Pa": (1e-3, "kPa"), "kg": (1e3, "g")}
"""Units of the table, what numbers are multiplied by, and units that people read."""

_WIDE = 30.0
"""Numbers that are this many times as large as the least are drawn on a logarithmic scale."""


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class Column:
    """A parameter or a quantity.

    Attributes:
        name: as in the table.
        unit: of the values, SI; "-" for none.
        values: numbers, NaN where there is none, or texts, shape (K,).
        spaced: whether numbers are evenly spaced in their logarithm.
    """

    name: str
    unit: str
    values: NDArray[Any]
    spaced: bool = False

    @property
    def numeric(self) -> bool:
        """Whether it holds numbers."""
        return bool(np.issubdtype(self.values.dtype, np.number))

    @property
    def shown(self) -> Array:
        """Numbers in the unit that people read."""
        return np.asarray(self.values * _READ.get(self.unit, (1.0, ""))[0], dtype=float)

    @property
    def label(self) -> str:
        """Name and unit for an axis."""
        unit = _READ.get(self.unit, (1.0, self.unit.replace("^2", "²")))[1]
        return f"{self.name.replace('_percent', '').replace('_', ' ')}{'' if unit == '-' else f' [{unit}]'}"

    @property
    def log(self) -> bool:
        """Whether its numbers are better told on a logarithmic scale."""
        known = self.shown[np.isfinite(self.shown)] if self.numeric else np.zeros(0)
        return len(known) > 0 and known.min() > 0 and (self.spaced or known.max() > _WIDE * known.min())

    def chosen(self, rows: NDArray[Any]) -> Column:
        """Return some of its rows."""
        return Column(self.name, self.unit, self.values[rows], self.spaced)


@dataclass(frozen=True, eq=False)
class Sorted:
    """Rows of a column sorted into levels, or into bins.

    Attributes:
        place: the level or bin of each row, from 0, shape (K,).
        count: how many there are.
        names: of the levels; of bins of their edges, one more.
        centres: values of the levels, middles of bins, in the unit that people read; numbers of levels, of texts.
        binned: whether these are bins.
    """

    place: NDArray[Any]
    count: int
    names: list[str]
    centres: Array
    binned: bool


def sorted_into(column: Column, bins: int) -> Sorted:
    """Return the levels of a column, or so many bins of one with many different values."""
    if not column.numeric:
        levels, place = np.unique(column.values.astype(str), return_inverse=True)
        return Sorted(place, len(levels), list(levels), np.arange(len(levels), dtype=float), False)
    shown = column.shown
    levels, place = np.unique(np.round(shown, 12), return_inverse=True)
    if len(levels) <= LEVELS:
        return Sorted(place, len(levels), [f"{level:.3g}" for level in levels], levels, False)
    low, high = float(shown.min()), float(shown.max())
    edges = np.geomspace(low, high, bins + 1) if column.log else np.linspace(low, high, bins + 1)
    place = np.clip(np.searchsorted(edges, shown, side="right") - 1, 0, bins - 1)
    middles = np.sqrt(edges[1:] * edges[:-1]) if column.log else 0.5 * (edges[1:] + edges[:-1])
    return Sorted(place, bins, [f"{edge:.3g}" for edge in edges], middles, True)


def bins_for(cases: int, axes: int) -> int:
    """Return into how many bins each of one or two axes is sorted: some ten cases each or more, where there are any."""
    return int(np.clip((cases / 10) ** (1 / axes), 4, 12 if axes == 2 else 20))


def effect(column: Column, values: Array) -> float:
    """Return the share of the variance of some values, shape (K,), between the levels or bins of a column."""
    known = np.isfinite(values)
    if known.sum() < 2 or np.ptp(values[known]) == 0:
        return 0.0
    groups = sorted_into(column.chosen(known), 8)
    means = np.array([values[known][groups.place == k].mean() if (groups.place == k).any() else 0.0
                      for k in range(groups.count)])  # fmt: skip
    return float(np.var(means[groups.place]) / np.var(values[known]))


def by_effect(columns: list[Column], values: Array) -> list[Column]:
    """Return columns that have more than one value, that of the largest effect on some values first."""
    varied = [column for column in columns if len(np.unique(column.values)) > 1]
    return sorted(varied, key=lambda column: -effect(column, values))


def name_places(axis: Any, groups: Sorted, most: int) -> None:
    """Name levels, or edges of bins, on an axis of their numbers; at most so many of them, evenly."""
    places = np.arange(len(groups.names)) - 0.5 * groups.binned
    step = -(-len(places) // max(most, 1))
    axis.set_ticks(places[::step], groups.names[::step])
    axis.set_minor_locator(_none())


def _none() -> Any:
    from matplotlib.ticker import NullLocator

    return NullLocator()

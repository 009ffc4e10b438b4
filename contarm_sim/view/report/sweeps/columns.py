"""Columns of a sweep's table as they are drawn: in units that people read, sorted into levels or bins."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.sweeps.effects import effect

LEVELS = 24
"""A parameter with more different values is sorted into bins."""

READ = {"m": (1e3, "mm"), "rad": (180 / np.pi, "deg"), "Pa": (1e-3, "kPa"), "kg": (1e3, "g")}
"""Units of the table, what numbers are multiplied by, and units that people read."""

_OF_LENGTH = "_percent"
"""How names of shares of the arm's length end."""

_SAID = {"contact_max": "tip motion by contact max"}
"""Names that do not say enough, in more words."""

_WIDE = 10.0
"""Numbers that are this many times as large as the least are drawn on a logarithmic scale."""


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class Column:
    """A parameter or a quantity.

    Attributes:
        name: as in the table.
        unit: of the values, SI; "-" for none.
        values: numbers, NaN where there is none, or texts, shape (K,).
        spaced: whether numbers are evenly spaced in their logarithm; None: as their range suggests.
        drawn: whether values are drawn from a range, so that none of them is a level.
    """

    name: str
    unit: str
    values: NDArray[Any]
    spaced: bool | None = None
    drawn: bool = False

    @property
    def numeric(self) -> bool:
        """Whether it holds numbers."""
        return bool(np.issubdtype(self.values.dtype, np.number))

    @property
    def shown(self) -> Array:
        """Numbers in the unit that people read."""
        return np.asarray(self.values * READ.get(self.unit, (1.0, ""))[0], dtype=float)

    @property
    def label(self) -> str:
        """Name and unit for an axis."""
        unit = self.read_unit.replace(" ", "\u00a0")  # it is not broken
        return f"{self.words}{'' if unit == '-' else f' [{unit}]'}"

    @property
    def words(self) -> str:
        """Name without unit."""
        name = self.name.removesuffix(_OF_LENGTH if self.unit == "%" else "")
        return _SAID.get(name, name).replace("_", " ").replace(".", " ")

    @property
    def read_unit(self) -> str:
        """The unit that people read; "-" for none."""
        if self.unit == "%" and self.name.endswith(_OF_LENGTH):
            return "% of length"
        return READ.get(self.unit, (1.0, self.unit.replace("^2", "²")))[1]

    def wrapped(self, letters: int) -> str:
        """Return the label in lines of at most so many letters, where that can be."""
        return textwrap.fill(self.label, letters)

    @property
    def log(self) -> bool:
        """Whether its numbers are better told on a logarithmic scale."""
        known = self.shown[np.isfinite(self.shown)] if self.numeric else np.zeros(0)
        if len(known) == 0 or known.min() <= 0:
            return False
        return bool(known.max() > _WIDE * known.min()) if self.spaced is None else self.spaced

    def chosen(self, rows: NDArray[Any]) -> Column:
        """Return some of its rows."""
        return Column(self.name, self.unit, self.values[rows], self.spaced, self.drawn)


@dataclass(frozen=True, eq=False)
class Sorted:
    """Rows of a column sorted into levels, or into bins.

    Attributes:
        place: the level or bin of each row, from 0, shape (K,).
        count: how many there are.
        names: of the levels; none of bins.
        at: values of the levels, in the unit that people read; of bins their edges, one more; numbers of texts.
        centres: values of the levels, middles of bins, in the unit that people read; numbers of levels, of texts.
        binned: whether these are bins.
    """

    place: NDArray[Any]
    count: int
    names: list[str]
    at: Array
    centres: Array
    binned: bool


def sorted_into(column: Column, bins: int) -> Sorted:
    """Return the levels of a column, or so many bins of one with many different values."""
    if not column.numeric:
        levels, place = np.unique(column.values.astype(str), return_inverse=True)
        numbers = np.arange(len(levels), dtype=float)
        return Sorted(place, len(levels), list(levels), numbers, numbers, False)
    shown = column.shown
    levels, place = np.unique(np.round(shown, 12), return_inverse=True)
    if len(levels) <= (1 if column.drawn else LEVELS):
        return Sorted(place, len(levels), [in_digits(level) for level in levels], levels, levels, False)
    low, high = float(shown.min()), float(shown.max())
    edges = np.geomspace(low, high, bins + 1) if column.log else np.linspace(low, high, bins + 1)
    place = np.clip(np.searchsorted(edges, shown, side="right") - 1, 0, bins - 1)
    middles = np.sqrt(edges[1:] * edges[:-1]) if column.log else 0.5 * (edges[1:] + edges[:-1])
    return Sorted(place, bins, [], edges, middles, True)


def in_digits(number: float) -> str:
    """Return a number in three digits."""
    rounded = float(f"{number:.3g}")
    return f"{rounded:g}".replace("e+0", "e").replace("e-0", "e-")


def bins_for(cases: int, axes: int) -> int:
    """Return into how many bins each of one or two axes is sorted: some twenty cases each, where there are as many."""
    return int(np.clip((cases / 20) ** (1 / axes), 4, 12 if axes == 2 else 16))


def by_effect(columns: list[Column], values: Array) -> list[Column]:
    """Return columns that have more than one value, that of the largest effect on some values first."""
    varied = [column for column in columns if len(np.unique(column.values)) > 1]
    return sorted(varied, key=lambda column: -effect(column.values, values, column.drawn).share)


def axes_of(columns: list[Column], values: Array) -> tuple[Column, Column, list[Column]]:
    """Return two of the columns for a map, across and upwards, and the others: numbers before texts, by effect."""
    ranked = sorted(by_effect(columns, values), key=lambda column: not column.numeric)
    across, upwards, *others = ranked + [column for column in columns if column not in ranked]
    return across, upwards, others

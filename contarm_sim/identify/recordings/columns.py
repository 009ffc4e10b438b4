"""Columns of data by name, of files and pandas frames: numbers and labels; every refusal says row and column."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.errors import InputError, did_you_mean
from contarm_sim.kinematics.arrays import Array

GAPS = ("", "nan", "na", "n/a", "null", "none", "-")
"""What an absent number is written as, in any case, beside what a recording's [gaps] say."""

_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?|[-+]?\d+,")
_NO = ("", "0", "0.0", "false", "no", "nan", "lost", "n", "f")


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns by name, T rows.

    Attributes:
        cells: of each column, texts or numbers.
        rows: number of each row in the file, the first line being 1; of arrays and frames the first row.
        where: the file.
        twice: names that several columns have.
        commas: whether decimal points may be commas.
    """

    cells: Mapping[str, Sequence[str] | Array]
    rows: Sequence[int]
    where: str
    twice: frozenset[str] = frozenset()
    commas: bool = False

    def __len__(self) -> int:
        return len(self.rows)

    def named(self, given: Any, key: str, size: int | None = None) -> list[str]:
        """Return names of columns that a key gives: a list, or the name of an array of several columns (npz).

        Raises:
            InputError: no names, not as many, one twice, or no such columns (with the nearest name).
        """
        names = given
        if isinstance(given, str):
            parts = [name for name in self.cells if re.fullmatch(re.escape(given) + r"\.\d+", name)]
            names = parts or [given]
        if not isinstance(names, (list, tuple)) or not names or not all(isinstance(name, str) for name in names):
            raise InputError(key, given, "names of columns, such as ['x', 'y', 'z']")
        for name in names:
            self._cells(name, key)
        if size is not None and len(names) != size:
            raise InputError(key, f"{len(names)} columns", f"{size} names of columns")
        if len(set(names)) < len(names):
            raise InputError(key, names, "each column once")
        return list(names)

    def numbers(self, name: str, key: str, gaps: Sequence[Any] = ()) -> Array:
        """Return a column of numbers, shape (T,); NaN where one is absent.

        Args:
            gaps: numbers and texts that say so, beside `GAPS`.

        Raises:
            InputError: no such column, or a cell that is no finite number.
        """
        cells, given = self._cells(name, key), [one for one in gaps if not isinstance(one, str)]
        if isinstance(cells, np.ndarray):
            found = cells.astype(float)
        else:
            try:
                found = np.array(list(map(float, cells)))
            except ValueError:
                absent = {*GAPS, *(one.strip().lower() for one in gaps if isinstance(one, str))}
                found = np.array([self._number(name, number, cell, absent) for number, cell in enumerate(cells)])
        for one in given:
            found[found == one] = math.nan
        if np.isinf(found).any():
            number = int(np.flatnonzero(np.isinf(found))[0])
            raise self.bad(name, number, str(found[number]), "a finite number")
        return found

    def texts(self, name: str, key: str) -> list[str]:
        """Return a column of labels; whole numbers without a point.

        Raises:
            InputError: no such column.
        """
        cells = self._cells(name, key)
        if not isinstance(cells, np.ndarray):
            return list(cells)
        return [f"{x:g}" if float(x).is_integer() else repr(float(x)) for x in cells.tolist()]

    def seen(self, name: str, key: str) -> Any:
        """Return where a column that says "valid" says so, shape (T,).

        Raises:
            InputError: no such column.
        """
        return np.array([cell.strip().lower() not in _NO for cell in self.texts(name, key)])

    def bad(self, name: str, number: int, given: str, allowed: str) -> InputError:
        """Return the error of one cell, given by the number of its row from 0."""
        return InputError(f"row {self.rows[number]}, column {name}", given, allowed, self.where)

    def _cells(self, name: Any, key: str) -> Sequence[str] | Array:
        if not isinstance(name, str):
            raise InputError(key, name, "the name of a column")
        if name not in self.cells:
            every = ", ".join(list(self.cells)[:24])
            hint = "; put commas, semicolons or tabs between them" if len(self.cells) == 1 and " " in every else ""
            allowed = f"{did_you_mean(name, self.cells)}the columns are {every}{hint}"
            raise InputError(key, f"{name!r}, which is no column", allowed, self.where)
        if name in self.twice:
            raise InputError("header", f"two columns named {name!r}", "each name that is used once", self.where)
        return self.cells[name]

    def _number(self, name: str, number: int, cell: str, absent: set[str]) -> float:
        text = cell.strip()
        if text.lower() in absent:
            return math.nan
        if self.commas and _DECIMAL_COMMA.fullmatch(text):
            text = text.replace(",", ".")
        try:
            return float(text)
        except ValueError:
            raise self.bad(name, number, repr(cell), "a number, or nothing where one is missing") from None


def of_frame(frame: Any, where: str = "frame") -> Columns:
    """Return the columns of a pandas frame; its index is not read.

    Raises:
        InputError: it is none, or is empty.
    """
    if not hasattr(frame, "columns") or not hasattr(frame, "to_numpy"):
        raise InputError("frame", type(frame).__name__, "a pandas.DataFrame")
    names, cells = [str(name) for name in frame.columns], {}
    for place, name in enumerate(names):
        column = frame.iloc[:, place]
        numeric = getattr(column.dtype, "kind", "O") in "biuf"
        cells[name] = column.to_numpy(dtype=float) if numeric else ["" if x != x else str(x) for x in column]
    return filled(cells, range(1, len(frame) + 1), where, names)


def filled(cells: dict[str, Any], rows: Sequence[int], where: str, names: list[str], commas: bool = False) -> Columns:
    """Return columns of rows that there are.

    Raises:
        InputError: there are none.
    """
    if not len(rows):
        raise InputError("data", "empty", "one row or more under the names of columns", where)
    twice = frozenset(name for name in names if names.count(name) > 1)
    return Columns(cells, rows, where, twice, commas)

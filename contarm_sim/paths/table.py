"""Tables of numbers as spreadsheets and scripts write them: commas, semicolons or tabs, decimal points or commas."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.units import factor

_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?|[-+]?\d+,")
_HEAD = re.compile(r"(.*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?")


@dataclass(frozen=True)
class Table:
    """Columns of numbers in SI units.

    Attributes:
        columns: by name, each of shape (T,).
        rows: number of each row in the file, the first line being 1.
        notes: what was converted and what was left out, for people to read.
    """

    columns: dict[str, Array]
    rows: list[int]
    notes: list[str]


def read_table(text: str, units: dict[str, str], aliases: dict[str, str], headless: Sequence[str], where: str) -> Table:
    """Return the columns of a table whose names are known; others are left out, and named in `notes`.

    Args:
        units: the names of columns, and the SI unit of each; a header may give another, `x [mm]`.
        aliases: other names for them.
        headless: the columns of a table without a header, in order; the last ones of these where it has fewer.
        where: the file, for messages.

    Raises:
        InputError: an empty table, an unknown unit, a column twice, or a bad cell, with its row and column.
    """
    wanted = f"columns {','.join(headless[-3:])} or {','.join(headless)}"
    lines, separator = _lines(text, wanted, where)
    if not lines:
        raise InputError("file", "empty", f"a CSV file with {wanted}", where)
    heads, notes, scales = lines[0][1], [], [1.0] * len(lines[0][1])
    if _is_number(heads[0], separator) and all(_is_number(cell, separator) for cell in heads):
        if not 3 <= len(heads) <= len(headless):
            raise InputError("file", f"{len(heads)} columns without a header", f"a header, or {wanted}", where)
        names = list(headless[-len(heads) :])
    else:
        found = [_head(cell, units, aliases, where) for cell in heads]
        names, scales = [name for name, _, _ in found], [scale for _, scale, _ in found]
        converted = [f"{name} from {unit} to {units[name]}" for name, scale, unit in found if name in units and unit]
        notes = [f"converted {', '.join(converted)}"] if any(s != 1 for s in scales) else []
        left = [repr(cell) for cell, name in zip(heads, names, strict=True) if name not in units]
        notes += [f"not read: {'column' if len(left) == 1 else 'columns'} {', '.join(left[:8])}"] if left else []
        lines = lines[1:]
    double = [name for name in units if names.count(name) > 1]
    if double:
        raise InputError("header", repr(",".join(heads)), f"each of {','.join(units)} once", where)
    columns = {}
    for place, name in enumerate(names):
        if name in units:
            cells = [_cell(row, place, name, number, where, len(names), separator) for number, row in lines]
            columns[name] = np.array(cells) * scales[place]
    return Table(columns, [number for number, _ in lines], notes)


def _lines(text: str, wanted: str, where: str) -> tuple[list[tuple[int, list[str]]], str]:
    """Return the rows that are not empty, numbered from 1, and what separates their cells."""
    first = next((line for line in text.splitlines() if line.strip()), "")
    separator = ";" if ";" in first else "\t" if "\t" in first else ","
    try:
        rows = list(csv.reader(io.StringIO(text), delimiter=separator, skipinitialspace=True))
    except csv.Error as error:
        raise InputError("file", f"not CSV ({error})", wanted, where) from error
    stripped = [(number, [cell.strip() for cell in row]) for number, row in enumerate(rows, 1)]
    return [(number, row) for number, row in stripped if any(row)], separator


def _head(cell: str, units: dict[str, str], aliases: dict[str, str], where: str) -> tuple[str, float, str]:
    """Return a column's name, what its unit is in SI units, and the unit as written (`x [mm]`, `x (mm)`, `x_mm`)."""
    found = _HEAD.fullmatch(cell.lower() if "[" not in cell and "(" not in cell else cell)
    name, unit = (found[1].lower(), found[2] or "") if found else (cell.lower(), "")
    base, _, ending = name.rpartition("_")
    if not unit and aliases.get(base, base) in units and factor(ending) is not None:
        name, unit = base, ending
    name = aliases.get(name, name)
    if name not in units or not unit:
        return name, 1.0, ""
    size, si = factor(unit), factor(units[name])
    if size is None or si is None or size[1] != si[1]:
        raise InputError(f"unit of column {name}", repr(unit), f"a unit such as {units[name]}, m{units[name]}", where)
    return name, size[0] / si[0], unit


def _number(text: str, separator: str) -> float:
    """Return a number; between semicolons and tabs its decimal point may be a comma."""
    if separator != "," and _DECIMAL_COMMA.fullmatch(text):
        text = text.replace(",", ".")
    try:
        return float(text)
    except ValueError:
        return math.nan


def _is_number(text: str, separator: str) -> bool:
    return math.isfinite(_number(text, separator))


def _cell(row: list[str], column: int, name: str, number: int, where: str, width: int, separator: str) -> float:
    if len(row) > width:
        commas = separator == "," and len(row) == 2 * width
        hint = "; if these are decimal commas, put semicolons between the columns" if commas else ""
        raise InputError(
            f"row {number}", f"one of {len(row)} cells", f"{width} cells, as in the first row{hint}", where
        )
    text = row[column] if column < len(row) else ""
    value = _number(text, separator)
    if not math.isfinite(value) or abs(value) > 1e9:
        spaced = " (put commas between the columns)" if len(text.split()) > 1 else ""
        raise InputError(f"row {number}, column {name}", repr(text), f"a finite number{spaced}", where)
    return value

"""Columns of data files: CSV (also .csv.gz), npz and pandas frames; every refusal says row and column."""

from __future__ import annotations

import csv
import gzip
import io
import math
import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import InputError, did_you_mean
from contarm_sim.inputs import read_bytes
from contarm_sim.kinematics.arrays import Array

MOST_BYTES = 2**29
"""Largest data file, also as unpacked [bytes]: nine hours of 16 columns at 100 Hz."""

GAPS = ("", "nan", "na", "n/a", "null", "none", "-")
"""What an absent number is written as, in any case, beside what a recording's [gaps] say."""

_WANTED = "a CSV file (also .csv.gz) with a line of names, or a .npz file"
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
            InputError: no names, not as many, or no such columns (with the nearest name).
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


def read_columns(path: Path, names: Sequence[str] | None = None, skip: int = 0) -> Columns:
    """Return the columns of a file.

    Args:
        names: of a CSV file without a line of names.
        skip: lines of a CSV file before its names.

    Raises:
        InputError: it cannot be read, is empty, has rows of several lengths, or is nothing of this sort.
    """
    content = read_bytes(path, _WANTED, MOST_BYTES)
    if path.name.lower().endswith(".npz"):
        return _of_npz(content, str(path))
    if path.name.lower().endswith(".gz"):
        content = _unpacked(content, str(path))
    return _of_csv(_text(content, str(path)), str(path), names, skip)


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
    return _filled(cells, range(1, len(frame) + 1), where, names)


def _filled(cells: dict[str, Any], rows: Sequence[int], where: str, names: list[str], commas: bool = False) -> Columns:
    if not len(rows):
        raise InputError("data", "empty", "one row or more under the names of columns", where)
    twice = frozenset(name for name in names if names.count(name) > 1)
    return Columns(cells, rows, where, twice, commas)


def _unpacked(content: bytes, where: str) -> bytes:
    try:
        found = gzip.GzipFile(fileobj=io.BytesIO(content)).read(MOST_BYTES + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError("file", f"no whole gzip file ({error})", _WANTED, where) from None
    if len(found) > MOST_BYTES:
        raise InputError("file", f"larger than {MOST_BYTES / 2**20:g} MiB", _WANTED, where)
    return found


def _text(content: bytes, where: str) -> str:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = content[: error.start].count(b"\n") + 1
        said = f"no text in UTF-8 (byte 0x{content[error.start]:02x} in row {row})"
        if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
            said = "text in UTF-16"
        raise InputError("file", said, f"{_WANTED}, saved as UTF-8", where) from None
    if "\0" in text:
        raise InputError("file", "no text (it has null characters)", _WANTED, where)
    return text


def _of_csv(text: str, where: str, names: Sequence[str] | None, skip: int) -> Columns:
    for _ in range(skip):
        text = text.partition("\n")[2]
    first = next((line for line in text.splitlines() if line.strip()), "")
    separator = ";" if ";" in first else "\t" if "\t" in first else ","
    reader, rows, lines = csv.reader(io.StringIO(text), delimiter=separator, skipinitialspace=True), [], []
    try:
        for row in reader:
            if row and (len(row) > 1 or row[0].strip()):
                rows.append(row)
                lines.append(reader.line_num + skip)
    except csv.Error as error:
        raise InputError("file", f"no CSV ({error})", _WANTED, where) from None
    if not rows:
        raise InputError("file", "empty", _WANTED, where)
    heads = [cell.strip() for cell in rows[0]] if names is None else list(names)
    if names is None:
        if all(_is_number(cell) for cell in heads):
            allowed = 'a line with the names of the columns, or their names in the TOML: names = ["t", "x", ...]'
            raise InputError("header", f"numbers ({','.join(heads)})", allowed, where)
        rows, lines = rows[1:], lines[1:]
    for line, row in zip(lines, rows, strict=True):
        if len(row) != len(heads):
            raise _ragged(line, len(row), len(heads), separator, where)
    cells = dict(zip(heads, map(list, zip(*rows, strict=True)), strict=True)) if rows else {}
    return _filled(cells, lines, where, heads, separator != ",")


def _ragged(line: int, found: int, wanted: int, separator: str, where: str) -> InputError:
    hint = ""
    if separator == "," and found > wanted:
        hint = "; if these are decimal commas, put semicolons between the columns"
    elif wanted == 1:
        hint = "; put commas, semicolons or tabs between the columns"
    return InputError(f"row {line}", f"one of {found} cells", f"{wanted}, as there are names{hint}", where)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _of_npz(content: bytes, where: str) -> Columns:
    """Return columns of arrays by name: of one of shape (T,) its own, of others `name.1`, `name.2`, ..."""
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except Exception:  # whatever NumPy and zipfile raise on a broken file
        raise InputError("file", "no .npz file of plain arrays", _WANTED, where) from None
    arrays = {name: array for name, array in arrays.items() if array.ndim}
    if not arrays:
        raise InputError("file", "empty", "a .npz file with arrays of one length", where)
    count = max(len(array) for array in arrays.values())
    cells: dict[str, Any] = {}
    for name, array in arrays.items():
        if len(array) != count:
            continue  # a setting, no column
        flat = array.reshape(count, -1) if count else array.reshape(0, 0)
        parts = {name: flat[:, 0]} if array.ndim == 1 else {f"{name}.{k + 1}": x for k, x in enumerate(flat.T)}
        cells |= {key: x if x.dtype.kind in "biuf" else [str(one) for one in x] for key, x in parts.items()}
    return _filled(cells, range(1, count + 1), where, list(cells))

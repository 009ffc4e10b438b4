"""Data files as people record them: CSV (also .csv.gz), with a line of names, and .npz."""

from __future__ import annotations

import csv
import gzip
import io
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.identify.recording_columns import Columns, filled
from contarm_sim.inputs import read_bytes

MOST_BYTES = 2**29
"""Largest data file, also as unpacked [bytes]: nine hours of 16 columns at 100 Hz."""

_WANTED = "a CSV file (also .csv.gz) with a line of names, or a .npz file"


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
    return filled(cells, lines, where, heads, separator != ",")


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
    return filled(cells, range(1, count + 1), where, list(cells))

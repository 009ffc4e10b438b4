"""Which rows of a data file count, which blocks they belong to, and when they were: [time], [block], keep and drop."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.identify.recording import Kind
from contarm_sim.identify.recording_columns import Columns
from contarm_sim.identify.spec_keys import in_si, numbers, one_number, table, whole
from contarm_sim.kinematics.arrays import Array


def payload_of(columns: Columns, given: Any) -> Array:
    """Return the payload of each row [kg], shape (T,): one for all, or of a column.

    Raises:
        InputError: neither, or one that is missing.
    """
    if not isinstance(given, dict):
        return np.full(len(columns), one_number(given, "kg", "payload"))
    given = table(given, "payload", ["column", "unit"])
    name = given.get("column")
    values, _ = in_si(columns.numbers(name, "payload.column"), given.get("unit"), ["kg"], "payload.unit")
    if not np.isfinite(values).all():
        raise columns.bad(name, int(np.flatnonzero(~np.isfinite(values))[0]), "missing", "a payload in each row")
    return values


def blocks_of(columns: Columns, own: dict[str, Any], given: Any, several: bool) -> list[str]:
    """Return the block of each row: of its file, of a column, and of how often a column began again.

    Args:
        own: what is said of the file, see `data`.
        given: what `block` says.
        several: whether there are other files: then each is a block at least.

    Raises:
        InputError: unknown keys, no such column, or no regular expression.
    """
    given = {"column": given} if isinstance(given, str) else {} if given is None else given
    given = table(given, "block", ["column", "match", "restart", "seconds"])
    stem = Path(columns.where).name.split(".")[0] if several else ""
    before = str(own.get("block", stem))
    labels = [before] * len(columns)
    if "column" in given:
        texts = [_matched(text, given.get("match")) for text in columns.texts(given["column"], "block.column")]
        labels = [f"{one}/{text}" if one else text for one, text in zip(labels, texts, strict=True)]
    if "restart" in given:
        counted = columns.numbers(given["restart"], "block.restart")
        number = 1 + np.cumsum(np.diff(counted, prepend=counted[0]) < 0)
        labels = [f"{one}/{k}" if one else str(k) for one, k in zip(labels, number.tolist(), strict=True)]
    return labels


def _matched(text: str, pattern: Any) -> str:
    """Return the part of a label that a regular expression finds: its first group, or all that it matches."""
    if pattern is None:
        return text
    try:
        found = re.search(pattern, text)
    except (re.error, TypeError) as error:
        raise InputError("block.match", pattern, f"a regular expression ({error})") from None
    if found is None:
        return text
    return found[1] if found.re.groups and found[1] is not None else found[0]


def time_of(columns: Columns, spec: dict[str, Any], kind: Kind, blocks: list[str]) -> tuple[Array, list[str]]:
    """Return the time of each row [s], not yet from its origin, and the blocks, cut at `block.seconds`.

    Raises:
        InputError: a motion without times, unknown keys or units, or a row without a time.
    """
    given = spec.get("time")
    if given is None:
        if kind == "motion":
            raise InputError("time", "missing", "a table with column and unit, or rate [Hz], of a motion")
        given = {"rate": 1}  # poses at rest: one a second
    given = table(given, "time", ["column", "unit", "rate", "origin"])
    rate = one_number(given["rate"], "1/s", "time.rate") if "rate" in given else None
    if rate is not None and not rate > 0:
        raise InputError("time.rate", rate, "a number above 0 [Hz]")
    if "column" in given:
        values = columns.numbers(given["column"], "time.column")
        if not np.isfinite(values).all():
            number = int(np.flatnonzero(~np.isfinite(values))[0])
            raise columns.bad(given["column"], number, "missing", "a time in each row")
        if rate is None:
            values, _ = in_si(values, given.get("unit"), ["s"], "time.unit")
        elif "unit" in given:
            raise InputError("time.unit", repr(given["unit"]), "a unit, or the rate of a column that counts samples")
        else:
            values = values / rate
    elif rate is not None:
        seen: dict[str, int] = {}
        values = np.empty(len(columns))
        for number, block in enumerate(blocks):
            seen[block] = seen.get(block, -1) + 1
            values[number] = seen[block] / rate
    else:
        raise InputError("time", given, "a table with column and unit, or rate [Hz]")
    cut = spec["block"].get("seconds") if isinstance(spec.get("block"), dict) else None
    if cut is None:
        return values, blocks
    length = one_number(cut, "s", "block.seconds")
    if not length > 0:
        raise InputError("block.seconds", cut, "a time above 0")
    return values, _cut(values, blocks, length)


def _cut(time: Array, blocks: list[str], length: float) -> list[str]:
    """Return blocks cut into pieces of a length [s]; what is left over is of the last piece."""
    names = np.array(blocks)
    out = list(blocks)
    for block in dict.fromkeys(blocks):
        rows = np.flatnonzero(names == block)
        since = time[rows] - time[rows].min()
        last = max(1, round(float(since.max()) / length))
        for row, piece in zip(rows.tolist(), np.minimum(since // length, last - 1).tolist(), strict=True):
            out[row] = f"{block}/{piece + 1:.0f}" if block else f"{piece + 1:.0f}"
    return out


def kept(time: Array, blocks: Sequence[str], there: Any, spec: dict[str, Any]) -> Any:
    """Return which rows belong to the recording, shape (T,): those that are kept, and every nth of a block.

    Args:
        time: of each, from the recording's origin [s].
        there: which have commands.

    Raises:
        InputError: no ranges, or no names.
    """
    rows = np.array(there)
    for key in ("keep", "drop"):
        given = table(spec.get(key, {}), key, ["time", "blocks"])
        found: dict[str, Any] = {}
        if "time" in given:
            ranges = given["time"] if isinstance(given["time"], list) else []
            ranges = [ranges] if ranges and not isinstance(ranges[0], list) else ranges
            if not ranges:
                raise InputError(f"{key}.time", given["time"], "a range [from, to] in s, or several")
            spans = [numbers(one, "s", f"{key}.time", 2) for one in ranges]
            found["time"] = np.logical_or.reduce([(low <= time) & (time <= high) for low, high in spans])
        if "blocks" in given:
            wanted = [given["blocks"]] if isinstance(given["blocks"], str) else given["blocks"]
            if not isinstance(wanted, list) or not all(isinstance(one, str) for one in wanted):
                raise InputError(f"{key}.blocks", given["blocks"], 'names of blocks; "rep1_*" are all that begin so')
            found["blocks"] = np.array([any(fnmatchcase(block, one) for one in wanted) for block in blocks])
        if found:
            rows = rows & np.logical_and.reduce(list(found.values())) if key == "keep" else (
                rows & ~np.logical_or.reduce(list(found.values())))  # fmt: skip
    nth = whole(spec.get("every", 1), "every")
    if nth > 1:
        seen: dict[str, int] = {}
        for number in np.flatnonzero(rows).tolist():
            block = blocks[number]
            seen[block] = seen.get(block, -1) + 1
            rows[number] = seen[block] % nth == 0
    return rows

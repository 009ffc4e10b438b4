"""Recordings of files: a TOML names the data, columns, units, frames and gaps; see docs/howto/recordings.md."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.identify.recording import KINDS, Kind, Recording, backwards
from contarm_sim.identify.recording_checks import check_against, check_enough
from contarm_sim.identify.recording_columns import Columns, of_frame, read_columns
from contarm_sim.identify.recording_commands import Commanded, commanded
from contarm_sim.identify.recording_measured import Measured, mark_frozen, measured
from contarm_sim.identify.rig import Rig
from contarm_sim.identify.rig_file import frame_of, read_toml
from contarm_sim.identify.spec_keys import choice, in_si, numbers, one_number, table, whole
from contarm_sim.inputs import as_path
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_table import refuse_unknown
from contarm_sim.model.parameters import as_number

KEYS = (
    "name", "source", "licence", "kind", "data", "names", "skip", "time", "block", "commands", "markers", "frame",
    "payload", "force", "gaps", "keep", "drop", "every",
)  # fmt: skip
"""Keys of a recording's TOML."""


@dataclass(frozen=True, eq=False)
class _Piece:
    """What one data file holds, T rows: the arguments of a recording, and where its rows are."""

    columns: Columns
    time: Array
    blocks: list[str]
    commands: Commanded
    measured: Measured
    payload: Array | None


def load_recording(path: str | Path, arm: Arm | None = None) -> Recording:
    """Read a recording that a TOML describes; its data lie beside it, or where it says.

    Args:
        arm: that was recorded: the recording is checked against it, and places of markers may be said by station,
            place [m] or section_end.

    Raises:
        InputError: a file that cannot be read; an unknown key; columns that are missing, no numbers or out of order; a
            marker that is never seen; with an arm, positions or commands that cannot be this arm's.
    """
    file = as_path("recording", path, "a TOML file")
    spec = read_toml(file, 'data = "poses.csv"')
    try:
        refuse_unknown(spec, KEYS)
        given = _files(spec.get("data"))
        names, skip = spec.get("names"), whole(spec.get("skip", 0), "skip", 0)
        if names is not None and (not isinstance(names, list) or not all(isinstance(one, str) for one in names)):
            raise InputError("names", names, "a list of names of columns")
        parts = [
            (read_columns(file.parent / as_path("data", one["file"], "a file"), names, skip), one) for one in given
        ]
        return _recording(parts, spec, arm, file.stem)
    except InputError as error:
        own = error.where in (None, spec.get("name", file.stem))
        raise error.located(str(file) if own else error.where) from None


def recording_from_frame(frame: Any, spec: dict[str, Any], arm: Arm | None = None) -> Recording:
    """Return the recording that a pandas frame holds.

    Args:
        frame: its columns.
        spec: what the TOML of `load_recording` says, as a dict, without `data`.
        arm: see `load_recording`.

    Raises:
        InputError: as `load_recording`.
    """
    refuse_unknown(spec, [key for key in KEYS if key not in ("data", "names", "skip")])
    return _recording([(of_frame(frame), {})], spec, arm, "recording")


def _files(data: Any) -> list[dict[str, Any]]:
    """Return the data files: their names, and what is the same in all of one, `block` and `payload`."""
    given = data if isinstance(data, list) else [data]
    found = [{"file": one} if isinstance(one, str) else one for one in given]
    if not found or not all(isinstance(one, dict) and isinstance(one.get("file"), str) for one in found):
        allowed = 'a file ("poses.csv", .csv.gz, .npz), a list of them, or [[data]] with file, block and payload'
        raise InputError("data", "missing" if data is None else data, allowed)
    return [table(one, "data", ["file", "block", "payload"]) for one in found]


def _recording(
    parts: list[tuple[Columns, dict[str, Any]]], spec: dict[str, Any], arm: Arm | None, usual: str
) -> Recording:
    kind: Any = choice(spec.get("kind"), "kind", KINDS)
    name = spec.get("name", usual)
    if not isinstance(name, str) or not name.strip():
        raise InputError("name", name, "a text")
    pieces = [_piece(columns, own, spec, kind, arm, len(parts) > 1) for columns, own in parts]
    _unique(pieces, kind)
    first = pieces[0]
    origin = _origin(spec, first)
    chosen = [np.flatnonzero(_kept(piece, piece.time - origin, spec)) for piece in pieces]
    if not sum(map(len, chosen)):
        raise InputError("keep", "nothing", "one sample or more that has commands", first.columns.where)
    for piece, rows in zip(pieces, chosen, strict=True):
        if found := backwards(piece.time[rows] - origin, np.array(piece.blocks)[rows], kind):
            number = int(rows[found[0]])
            given = f"{piece.time[number] - origin:.9g} s"
            raise InputError(f"row {piece.columns.rows[number]}, time", given, found[1], piece.columns.where)

    def joined(values: list[Any]) -> Any:
        own = [one[rows] for one, rows in zip(values, chosen, strict=True) if one is not None]
        return np.concatenate(own) if own else None

    payloads = [piece.payload for piece in pieces]
    if any(one is None for one in payloads) and any(one is not None for one in payloads):
        raise InputError("payload", "said of some files alone", "of each of [[data]], or of none")
    rig = Rig(markers=first.measured.markers, actuation=first.commands.actuation, **frame_of(spec.get("frame", {})))
    recording = Recording(
        kind=kind,
        time=joined([piece.time for piece in pieces]) - origin,
        positions=joined([piece.measured.positions for piece in pieces]),
        commands=joined([piece.commands.values for piece in pieces]),
        rig=rig,
        blocks=joined([np.array(piece.blocks) for piece in pieces]),
        payload=joined(payloads),
        force=joined([piece.measured.force for piece in pieces]),
        force_xi=first.measured.force_xi,
        name=name,
    )
    check_enough(recording)
    if arm is not None:
        check_against(recording, arm)
    return recording


def _piece(
    columns: Columns, own: dict[str, Any], spec: dict[str, Any], kind: Kind, arm: Arm | None, several: bool
) -> _Piece:
    gaps = spec.get("gaps", {})
    gaps = gaps if isinstance(gaps, dict) else {"values": gaps}
    gaps = table(gaps, "gaps", ["values", "valid", "frozen"])
    values = gaps.get("values", [])
    values = values if isinstance(values, list) else [values]
    if not all(isinstance(one, str) or math.isfinite(as_number(one)) for one in values):
        raise InputError("gaps.values", values, "numbers and texts that say that one is missing, such as [-9999]")
    blocks = _blocks(columns, own, spec.get("block"), several)
    time, blocks = _time(columns, spec, kind, blocks)
    found = measured(columns, spec, {**gaps, "values": values}, arm)
    found = mark_frozen(found, blocks, gaps.get("frozen"))
    payload = own.get("payload", spec.get("payload"))
    return _Piece(columns, time, blocks, commanded(columns, spec.get("commands"), values), found,
                  None if payload is None else _payload(columns, payload))  # fmt: skip


def _payload(columns: Columns, given: Any) -> Array:
    if not isinstance(given, dict):
        return np.full(len(columns), one_number(given, "kg", "payload"))
    given = table(given, "payload", ["column", "unit"])
    name = given.get("column")
    values, _ = in_si(columns.numbers(name, "payload.column"), given.get("unit"), ["kg"], "payload.unit")
    if not np.isfinite(values).all():
        raise columns.bad(name, int(np.flatnonzero(~np.isfinite(values))[0]), "missing", "a payload in each row")
    return values


def _blocks(columns: Columns, own: dict[str, Any], given: Any, several: bool) -> list[str]:
    """Return the block of each row: of its file, of a column, and of how often a column began again."""
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


def _time(columns: Columns, spec: dict[str, Any], kind: Kind, blocks: list[str]) -> tuple[Array, list[str]]:
    """Return the time of each row [s], not yet from its origin, and the blocks, cut at `block.seconds`."""
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


def _origin(spec: dict[str, Any], first: _Piece) -> float:
    """Return what counts as 0 s: of a column of times the first row's, if nothing else is said."""
    given = spec.get("time") or {}
    if "origin" in given:
        if "rate" in given:
            raise InputError("time.origin", given["origin"], "no origin beside a rate")
        origin, _ = in_si(
            np.array(one_number(given["origin"], "-", "time.origin")), given.get("unit"), ["s"], "time.unit"
        )
        return float(origin)
    return float(first.time[0])


def _unique(pieces: list[_Piece], kind: Kind) -> None:
    """Give blocks of a motion that begin again later a name of their own; those of other files as well."""
    if kind != "motion":
        return
    times: dict[str, int] = {}
    for piece in pieces:
        before = None
        for number, block in enumerate(piece.blocks):
            if block != before:
                times[block] = times.get(block, 0) + 1
            before = block
            if times[block] > 1:
                piece.blocks[number] = f"{block} ({times[block]})"


def _kept(piece: _Piece, time: Array, spec: dict[str, Any]) -> Any:
    """Return which rows belong to the recording: those that are kept, have commands, and every nth."""
    rows: Any = np.isfinite(piece.commands.values).all(axis=1)
    if not rows.any():
        raise InputError("commands", "missing in all rows", "numbers", piece.columns.where)
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
            found["blocks"] = np.array([any(fnmatchcase(block, one) for one in wanted) for block in piece.blocks])
        if found:
            rows = rows & np.logical_and.reduce(list(found.values())) if key == "keep" else (
                rows & ~np.logical_or.reduce(list(found.values())))  # fmt: skip
    nth = whole(spec.get("every", 1), "every")
    if nth > 1:
        seen: dict[str, int] = {}
        for number in np.flatnonzero(rows).tolist():
            block = piece.blocks[number]
            seen[block] = seen.get(block, -1) + 1
            rows[number] = seen[block] % nth == 0
    return rows

"""Recordings of files: a TOML names the data, columns, units, frames and gaps; see docs/howto/recordings.md."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.identify.recordings.checks import check_against, check_enough
from contarm_sim.identify.recordings.columns import Columns, of_frame
from contarm_sim.identify.recordings.commands import Commanded, commanded
from contarm_sim.identify.recordings.data_files import read_columns
from contarm_sim.identify.recordings.keys import choice, in_si, one_number, table, whole
from contarm_sim.identify.recordings.measured import Measured, mark_frozen, measured
from contarm_sim.identify.recordings.recording import KINDS, OTHERS, Kind, Recording, backwards
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.identify.recordings.rig_file import frame_of, read_toml
from contarm_sim.identify.recordings.rows import blocks_of, kept, payload_of, time_of
from contarm_sim.inputs import as_path
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_table import refuse_unknown
from contarm_sim.model.parameters import as_number

KEYS = (
    "name", "source", "licence", "kind", "data", "names", "skip", "time", "block", "commands", "markers", "frame",
    "payload", "force", "gaps", "keep", "drop", "every", *OTHERS,
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

    @property
    def there(self) -> Any:
        """Whether a row has commands, shape (T,)."""
        found: Any = np.isfinite(self.commands.values).all(axis=1)
        if not found.any():
            raise InputError("commands", "missing in all rows", "numbers", self.columns.where)
        return found


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
    chosen = [np.flatnonzero(kept(piece.time - origin, piece.blocks, piece.there, spec)) for piece in pieces]
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
        **{key: spec[key] for key in OTHERS if key in spec},
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
    blocks = blocks_of(columns, own, spec.get("block"), several)
    time, blocks = time_of(columns, spec, kind, blocks)
    found = measured(columns, spec, {**gaps, "values": values}, arm)
    found = mark_frozen(found, blocks, gaps.get("frozen"))
    payload = own.get("payload", spec.get("payload"))
    told = commanded(columns, spec.get("commands"), values, time, blocks)
    return _Piece(columns, time, blocks, told, found, None if payload is None else payload_of(columns, payload))


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

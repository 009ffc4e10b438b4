"""The tables [[markers]] and [force] of a recording, and how its gaps are written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.identify.recordings.columns import Columns
from contarm_sim.identify.recordings.keys import PLACES, in_si, place_of, table, whole
from contarm_sim.identify.recordings.rig import Marker
from contarm_sim.identify.recordings.rig_file import marker_of
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

_TURNED = ("orientation", "quaternion", "rotation", "pose")


@dataclass(frozen=True, eq=False)
class Measured:
    """Where K markers were [m], shape (T, K, 3), NaN where unseen, and the force [N] that acted, shape (T, 3)."""

    markers: tuple[Marker, ...]
    positions: Array
    force: Array | None
    force_xi: float


def measured(columns: Columns, spec: dict[str, Any], gaps: dict[str, Any], arm: Arm | None) -> Measured:
    """Return what the tables [[markers]] and [force] say.

    Raises:
        InputError: no markers, unknown keys, columns that are missing or have no numbers, or orientations.
    """
    given = spec.get("markers")
    if not isinstance(given, list) or not given:
        raise InputError(
            "markers", "missing" if given is None else given, "one table [[markers]] or more, with columns"
        )
    markers, positions = [], []
    for number, one in enumerate(given, 1):
        if isinstance(one, dict) and (turned := [key for key in _TURNED if key in one]):
            raise InputError(
                f"marker {number}.{turned[0]}", "not read yet", "columns of x, y and z: markers are points"
            )
        own = table(one, f"marker {number}", ["name", "columns", "unit", "offset", "valid", *PLACES])
        marker = marker_of(own, number, arm)
        where = f"marker {marker.name}"
        seen = _seen(columns, [own.get("valid"), gaps.get("valid")], where)
        positions.append(_vectors(columns, own, where, "m", gaps["values"], seen))
        markers.append(marker)
    force, xi = None, 1.0
    if "force" in spec:
        own = table(spec["force"], "force", ["columns", "unit", *PLACES])
        force, xi = _vectors(columns, own, "force", "N", [], None), place_of(own, "force", arm)
        if not np.isfinite(force).all():
            number = int(np.argwhere(~np.isfinite(force))[0][0])
            raise columns.bad(str(own["columns"][0]), number, "missing", "a force in each row, 0 for none")
    return Measured(tuple(markers), np.stack(positions, axis=1), force, xi)


def mark_frozen(found: Measured, blocks: list[str], least: Any) -> Measured:
    """Return the same with markers unseen where they stay at the very same place for `least` rows or more of a block.

    Args:
        least: None: nothing is changed.

    Raises:
        InputError: not a whole number above 1.
    """
    if least is None:
        return found
    positions = found.positions.copy()
    positions[frozen_runs(found.positions, np.array(blocks), whole(least, "gaps.frozen", 2))] = np.nan
    return replace(found, positions=positions)


def frozen_runs(positions: Array, blocks: Any, least: int) -> Any:
    """Return where markers stay at the very same place, shape (T, K), in runs of `least` samples or more of a block.

    The first of a run was seen, and is not counted to it.
    """
    same = np.zeros((len(positions), positions.shape[1]), dtype=bool)
    same[1:] = (positions[1:] == positions[:-1]).all(axis=-1) & (blocks[1:] == blocks[:-1])[:, None]
    out = np.zeros_like(same)
    for k in range(same.shape[1]):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], same[:, k], [False]]).astype(int)))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            out[begin:end, k] = end - begin + 1 >= least
    return out


def _vectors(columns: Columns, own: dict[str, Any], where: str, si: str, gaps: Sequence[Any], seen: Any) -> Array:
    if "columns" not in own:
        raise InputError(f"{where}.columns", "missing", "three names of columns: x, y and z")
    names = columns.named(own["columns"], f"{where}.columns", 3)
    raw = np.stack([columns.numbers(name, f"{where}.columns", gaps) for name in names], axis=1)
    values, _ = in_si(raw, own.get("unit"), [si], f"{where}.unit")
    values = np.array(values)
    if seen is not None:
        values[~seen] = np.nan
    return values


def _seen(columns: Columns, given: Sequence[Any], where: str) -> Any:
    names = [one for one in given if one is not None]
    masks = [columns.seen(name, f"{where}.valid") for name in names]
    return np.logical_and.reduce(masks) if masks else None

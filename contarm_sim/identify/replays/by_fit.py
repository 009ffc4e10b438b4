"""A recording as a fit predicts it: in the fitted rig, with the fit's covariance, and what of it was held out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contarm_sim.identify.fitted import Fit, Left
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.replays.covariance import Covariance, covariance_of
from contarm_sim.model.arm import Arm

SAME = 1e-9
"""By how much a coordinate may differ that was read twice [m]."""


@dataclass(frozen=True, eq=False)
class ByFit:
    """What a fit says of a recording of T samples.

    Attributes:
        recording: in the rig that predicts.
        held_out: whether a sample was kept from the fit, shape (T,); all of a recording that it was not made from.
        covariance: of the fit in that rig; None of another arm or rig, or where the fit determined nothing.
    """

    recording: Recording
    held_out: NDArray[np.bool_]
    covariance: Covariance | None


def by_fit(fit: Fit, arm: Arm, recording: Recording, own_rig: bool = False) -> ByFit:
    """Return a recording as a fit predicts it.

    Args:
        fit: that predicts.
        arm: that predicts; the fit's, or another.
        recording: as it was read.
        own_rig: whether it stays in its rig; else it is put into the fitted one: of the same recording if the fit was
            made from it, else of the fit's first.

    Raises:
        InputError: the fitted rig has another number of markers.
    """
    place, held_out = held_out_in(fit, recording)
    if own_rig:
        return ByFit(recording, held_out, None)
    covariance = covariance_of(fit, place or 0) if arm == fit.arm else None
    return ByFit(recording.in_rig(fit.rigs[place or 0]), held_out, covariance)


def held_out_in(fit: Fit, recording: Recording) -> tuple[int | None, NDArray[np.bool_]]:
    """Return which recording of a fit this is, from 0, and which of its T samples were kept from the fit, shape (T,).

    The same measurement has the same positions at the same times of the same blocks, as far as both know them: a fit
    may have had only every tenth sample, and does not know where a swing was before it began. Samples that it skipped
    count as the nearest that it had. None, and all, where the fit was not made from it.
    """
    for place, left in enumerate(fit.left):
        rows = _rows(left.recording, recording)
        if rows is not None:
            return place, ~_used(left, recording, rows)
    return None, np.ones(len(recording), dtype=np.bool_)


def _rows(one: Recording, other: Recording) -> NDArray[np.intp] | None:
    """Return which sample of a recording each of another is, -1: none; None where they are different measurements."""
    if one.positions.shape[1:] != other.positions.shape[1:]:
        return None
    at: dict[tuple[str, float, int], int] = {}
    for row, key in enumerate(_keys(one)):
        at[key] = row
    rows = np.array([at.get(key, -1) for key in _keys(other)])
    found = rows >= 0
    apart = np.abs(one.positions[rows[found]] - other.positions[found])
    known = np.isfinite(apart)
    return rows if known.any() and (apart[known] <= SAME).all() else None


def _keys(recording: Recording) -> list[tuple[str, float, int]]:
    """Return what tells samples apart: block, time [s], and which of those that have both alike."""
    met: dict[tuple[str, float], int] = {}
    keys = []
    for block, time in zip(recording.blocks.tolist(), np.round(recording.time, 9).tolist(), strict=True):
        met[block, time] = met.get((block, time), -1) + 1
        keys.append((block, time, met[block, time]))
    return keys


def _used(left: Left, recording: Recording, rows: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Return which samples a fit used, shape (T,), and their neighbours that were left out between them."""
    fitted = (rows >= 0) & ~np.asarray(left.held_out, dtype=np.bool_)[rows]
    used = fitted.copy()
    for block in set(recording.blocks[rows < 0].tolist()):
        own = np.flatnonzero(recording.blocks == block)
        (known,) = np.nonzero(rows[own] >= 0)
        if len(known):
            places = np.arange(len(own))
            nearest = known[np.rint(np.interp(places, known, np.arange(len(known)))).astype(int)]
            apart = np.median(np.diff(known)) if len(known) > 1 else len(own)
            used[own] = fitted[own[nearest]] & (np.abs(places - nearest) < apart)
    return used

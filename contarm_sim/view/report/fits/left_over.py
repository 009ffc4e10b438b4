"""What a fit leaves over, in numbers: errors fitted and held out, what the same command repeats to, hysteresis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.identify.differences import root_mean_square
from contarm_sim.identify.fitted import Fit, Left
from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.report.outliers import BEYOND, outliers

Rows = NDArray[np.bool_]

FITTED, HELD_OUT = "fitted", "held out"

DRIVEN = {"windings": ("winding", 1e3, "mm"), "tensions": ("tension", 1.0, "N"), "pressures": ("pressure", 1e-3, "kPa")}
"""What channels set, by how they drive: the word, and the unit that people read."""

_STILL = 1e-3
"""A command that changes by less [share of its range] is said to stay."""

_SAME = 0.01
"""Commands that differ by less [share of the largest range of any] are the same."""

_BINS, _FEW = 8, 5
"""Bins of a command, and samples that each needs for a median."""


@dataclass(frozen=True)
class Rms:
    """Sizes of errors [m].

    Attributes:
        samples: in which something was seen.
        rms: root mean square distance.
        centred: the same without the mean offset of each marker.
        median, most: of the distances; 95 % are below `most`.
    """

    samples: int
    rms: float
    centred: float
    median: float
    most: float


def parts(left: Left) -> dict[str, Rows]:
    """Return the masks of what was fitted and of what was held out, shape (T,), without empty ones."""
    held = np.asarray(left.held_out, dtype=bool)
    return {name: rows for name, rows in ((FITTED, ~held), (HELD_OUT, held)) if _seen(left, rows).any()}


def _seen(left: Left, rows: Rows) -> Rows:
    return np.asarray(np.isfinite(left.error).all(axis=-1).any(axis=-1) & rows)


def distances(left: Left) -> Array:
    """Return how far markers were from where they were predicted [m], shape (T, K); NaN where not seen."""
    return np.linalg.norm(left.error, axis=-1)


def rms(left: Left, rows: Rows, marker: int | None = None) -> Rms | None:
    """Return the sizes of the errors of some samples, of one marker or of all; None where nothing was seen."""
    found = left.differences(rows, marker)
    if not found.count:
        return None
    known = np.isfinite(distances(left)[rows])
    seen = (known if marker is None else known[:, [marker]]).any(axis=1)
    return Rms(int(seen.sum()), found.rms, found.centred_rms, found.median, found.percentile_95)


def pooled(fit: Fit, name: str) -> Array:
    """Return the distances [m] of all that was fitted, or held out, of all recordings and markers, shape (N,)."""
    own = [distances(left)[rows] for left in fit.left for part, rows in parts(left).items() if part == name]
    found = np.concatenate([each.ravel() for each in own]) if own else np.zeros(0)
    return found[np.isfinite(found)]


def together(fit: Fit, name: str) -> float:
    """Return the rms [m] of what was fitted, or held out, of all recordings; NaN where there is none."""
    return root_mean_square(pooled(fit, name))


def cleaned(left: Left) -> Left:
    """Return what is left over without outliers."""
    return replace(left, predicted=np.where(outliers(distances(left))[..., None], np.nan, left.predicted))


def blocks(left: Left) -> Iterator[tuple[str, Rows, bool]]:
    """Yield the blocks of a recording in their order: name, mask, and whether they were held out."""
    named = left.recording.blocks
    for name in dict.fromkeys(named.tolist()):
        of_it = named == name
        for held in (False, True):
            rows = of_it & (np.asarray(left.held_out, dtype=bool) == held)
            if _seen(left, rows).any():
                yield name, rows, held


@dataclass(frozen=True, eq=False)
class Driven:
    """What channels set.

    Attributes:
        values: in the unit that people read, shape (T, C).
        channels: their numbers, from 1.
        word, unit: such as winding, mm.
    """

    values: Array
    channels: tuple[int, ...]
    word: str
    unit: str


def driven(left: Left) -> Driven | None:
    """Return what the channels that drive something set; None where nothing is driven."""
    recording, actuation = left.recording, left.recording.rig.actuation
    used = sorted(set(actuation.channels))
    if actuation.drive == "none" or not used:
        return None
    word, factor, unit = DRIVEN[actuation.drive]
    values = factor * recording.commands[:, used] * np.array(actuation.gains)[used]
    return Driven(values, tuple(channel + 1 for channel in used), word, unit)


def repeatability(left: Left) -> tuple[float, int] | None:
    """Return how far [m] a marker is from its median each time that the same command comes, rms, and how many times.

    A command that is held counts once; outliers are left out. None where no command comes twice, or in a motion.
    """
    recording = left.recording
    commands, positions = recording.commands, recording.positions
    if recording.kind != "static" or not commands.shape[1] or not len(commands):
        return None
    grid = max(_SAME * float(np.ptp(commands, axis=0).max()), 1e-300)
    _, place = np.unique(np.round(commands / grid), axis=0, return_inverse=True)
    visit = np.concatenate([[0], np.cumsum(place[1:] != place[:-1])])
    first = np.concatenate([[0], np.flatnonzero(np.diff(visit)) + 1])
    apart: list[Array] = []
    for marker in range(positions.shape[1]):
        seen = np.isfinite(positions[:, marker]).all(axis=-1)
        count = np.bincount(visit[seen], minlength=len(first))
        totals = [np.bincount(visit[seen], x, len(first)) for x in positions[seen, marker].T]
        means = np.stack(totals, axis=1)[count > 0] / count[count > 0, None]
        of = place.reshape(-1)[first][count > 0]
        for command in np.flatnonzero(np.bincount(of) > 1):
            own = means[of == command]
            share = np.sqrt(len(own) / (len(own) - 1))  # a mean of few is nearer to them than the true one
            apart.append(share * np.linalg.norm(own - np.median(own, axis=0), axis=1))
    if not apart:
        return None
    sizes = np.concatenate(apart)
    return float(np.sqrt((sizes[sizes <= BEYOND * np.median(sizes)] ** 2).mean())), len(sizes)


@dataclass(frozen=True, eq=False)
class Hysteresis:
    """Errors of one marker along the way that one channel moves it, told apart by which way the command goes.

    Attributes:
        command: of the channel, in the unit that people read, shape (T,).
        along: the error, measured less predicted, along that way [m], shape (T,).
        growing, falling: masks, shape (T,).
        gap: how much the medians differ, growing less falling [m]; NaN where too few commands come both ways.
        middles: of the bins of the command, shape (B,).
        medians: of the errors in the bins [m], growing and falling, shape (B, 2).
    """

    command: Array
    along: Array
    growing: Rows
    falling: Rows
    gap: float
    middles: Array
    medians: Array


def hysteresis(left: Left, found: Driven, channel: int) -> Hysteresis | None:
    """Return the errors of the last marker by the way that a command goes, of one column; None where it never does."""
    told, recording = found.values, left.recording
    command, predicted = told[:, channel], left.predicted[:, -1]
    extent = float(np.ptp(command))
    known = np.isfinite(predicted).all(axis=-1)
    if not extent or known.sum() < told.shape[1] + 2:
        return None
    slopes = np.linalg.lstsq(np.column_stack([told, np.ones(len(told))])[known], predicted[known], rcond=None)[0]
    size = float(np.linalg.norm(slopes[channel]))
    if not size:
        return None
    along = left.error[:, -1] @ (slopes[channel] / size)
    way = _ways(command, recording.blocks, _STILL * extent)
    growing, falling = (np.asarray(np.isfinite(along) & (way == sign)) for sign in (1, -1))
    edges = np.linspace(command.min(), command.max(), _BINS + 1)
    place = np.clip(np.searchsorted(edges, command, side="right") - 1, 0, _BINS - 1)
    medians = np.array([[_median(along[rows & (place == k)]) for rows in (growing, falling)] for k in range(_BINS)])
    apart = medians[:, 0] - medians[:, 1]
    gap = float(np.nanmean(apart)) if np.isfinite(apart).any() else float("nan")
    return Hysteresis(command, along, growing, falling, gap, 0.5 * (edges[1:] + edges[:-1]), medians)


def _ways(command: Array, named: NDArray[Any], still: float) -> NDArray[Any]:
    """Return 1 where a command grew last, -1 where it fell, 0 where it has not changed yet in its block."""
    way, last = np.zeros(len(command)), 0.0
    for k in range(1, len(command)):
        if named[k] != named[k - 1]:
            last = 0.0
            continue
        change = command[k] - command[k - 1]
        last = float(np.sign(change)) if abs(change) > still else last
        way[k] = last
    return way


def _median(values: Array) -> float:
    return float(np.median(values)) if len(values) >= _FEW else float("nan")


def gaps(left: Left) -> dict[int, float]:
    """Return by channel, from 1, how much errors differ between growing and falling commands [m], where known."""
    found = driven(left)
    if found is None or left.recording.kind != "static":
        return {}
    own = {channel: hysteresis(left, found, place) for place, channel in enumerate(found.channels)}
    return {channel: one.gap for channel, one in own.items() if one is not None and np.isfinite(one.gap)}

"""Commands between their updates: a log that repeats what was last read lags behind an arm that moves on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

from contarm_sim.kinematics.arrays import Array

Between = Literal["held", "linear"]
BETWEEN: tuple[Between, ...] = get_args(Between)

_USUAL = 2.0
"""Updates that are farther apart than so many median spans had a rest between them, and no line."""


def drawn_through(values: Array, time: Array, blocks: Sequence[str]) -> Array:
    """Return commands that go straight from update to update, shape (T, C); after the last one of a block they stay.

    A row is an update if one channel or more differs from the row before it in its block. Where nothing changes for
    longer than `_USUAL` median spans, commands rest, and move over the last median span alone.

    Args:
        values: shape (T, C), NaN where one is missing.
        time: of the rows, shape (T,).
        blocks: of the rows; a stretch of one block is drawn for itself.
    """
    found, there = values.copy(), np.flatnonzero(np.isfinite(values).all(axis=1))
    names = np.asarray(blocks)[there]
    edges = np.flatnonzero(names[1:] != names[:-1]) + 1
    for rows in np.split(there, edges):
        own = values[rows]
        at = np.flatnonzero(np.r_[True, (own[1:] != own[:-1]).any(axis=1)][: len(rows)])
        if len(at) < 2:
            continue
        when, points = time[rows][at], own[at]
        spans = np.diff(when)
        usual = float(np.median(spans))
        rested = np.flatnonzero(spans > _USUAL * usual)
        points = np.insert(points, rested + 1, points[rested], axis=0)
        when = np.insert(when, rested + 1, when[rested + 1] - usual)
        found[rows] = np.stack([np.interp(time[rows], when, one) for one in points.T], axis=1)
    return found

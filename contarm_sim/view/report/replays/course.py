"""What the samples of a recording are drawn over: their numbers, or time, one block after the other."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from contarm_sim.identify.replay import Replay
from contarm_sim.kinematics.arrays import Array

GAP = 0.2
"""Between blocks of a motion whose time begins anew [s]."""


@dataclass(frozen=True, eq=False)
class Course:
    """Where T samples are drawn.

    Attributes:
        places: along the axis, shape (T,), growing.
        name: of the axis.
        parts: of the samples that lines are drawn through without a break.
    """

    places: Array
    name: str
    parts: tuple[slice, ...]


def course_of(replay: Replay) -> Course:
    """Return what a replay is drawn over: of static samples their numbers, from 1, for they may lie far apart."""
    recording = replay.recording
    starts = [0, *(np.flatnonzero(recording.blocks[1:] != recording.blocks[:-1]) + 1).tolist(), len(recording)]
    parts = tuple(slice(a, b) for a, b in pairwise(starts))
    if recording.kind == "static":
        return Course(np.arange(1.0, len(recording) + 1), "sample", parts)
    places, end = np.empty(len(recording)), 0.0
    whole = bool((np.diff(recording.time) > 0).all())
    for part in parts:
        own = recording.time[part]
        shift = 0.0 if whole else end - own[0]
        places[part] = own + shift
        end = places[part][-1] + GAP
    return Course(places, "time [s]" if whole or len(parts) == 1 else "time, one block after the other [s]", parts)


def broken(values: Array, course: Course) -> tuple[Array, Array]:
    """Return places and values, shape (T', ...), with NaN between the parts, so that no line joins them."""
    places = np.concatenate([np.append(course.places[part], np.nan) for part in course.parts])
    gap = np.full((1, *values.shape[1:]), np.nan)
    return places, np.concatenate([each for part in course.parts for each in (values[part], gap)])

"""Whole backbones of what a predictor predicts: it tells where markers are, so it is asked for markers all along."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from contarm_sim.identify.prediction.base import Predictor
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Marker
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

_CORNERS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
"""Points of a station's frame [m] that tell where it is and how it is turned."""


def station_xi(arm: Arm) -> Array:
    """Return the normalised arc lengths of an arm's stations, shape (N + 1,)."""
    ends = np.cumsum([0.0, *(section.length for section in arm.sections)])
    parts = [np.linspace(a, b, s.links, endpoint=False) for a, b, s in zip(ends, ends[1:], arm.sections, strict=False)]
    return np.minimum(np.concatenate([*parts, ends[-1:]]) / ends[-1], 1.0)


def backbones(
    arm: Arm, recording: Recording, predictor: Callable[[Recording], Predictor]
) -> tuple[Array, Array]:  # fmt: skip
    """Return the frames of an arm's stations that a predictor predicts, and where the markers are.

    The markers that were measured stay the first ones: a motion may start from them. Frames are in the base's frame,
    shape (T, N + 1, 4, 4), markers in that of the measurements [m], shape (T, K, 3).

    Args:
        arm: of N links.
        recording: of T samples, in its rig.
        predictor: what predicts a recording.
    """
    rig, own = recording.rig, len(recording.rig.markers)
    added = [Marker(name=f"station {n}", xi=float(xi), offset=corner)
             for n, xi in enumerate(station_xi(arm)) for corner in _CORNERS]  # fmt: skip
    unseen = np.full((len(recording), len(added), 3), np.nan)
    more = replace(rig, markers=(*rig.markers, *added))
    unseen[-1] = rig.position  # a recording's markers are seen once or more; nothing starts from its last sample
    asked = replace(recording, rig=more, positions=np.concatenate([recording.positions, unseen], axis=1))
    found = predictor(asked)([arm], [more])[0]
    points = (found[:, own:] - np.array(rig.position)) @ rig.rotation
    points = points.reshape(len(recording), -1, 3, 3)
    frames = np.zeros((*points.shape[:2], 4, 4))
    frames[..., :3, 3], frames[..., 3, 3] = points[..., 0, :], 1.0
    frames[..., :3, 0], frames[..., :3, 2] = (
        points[..., 1, :] - points[..., 0, :],
        points[..., 2, :] - points[..., 0, :],
    )
    frames[..., :3, 1] = np.cross(frames[..., :3, 2], frames[..., :3, 0])
    return frames, found[:, :own]

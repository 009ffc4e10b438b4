"""Which parameters the markers of recordings move with, and why some do not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.search.residuals import Problem
from contarm_sim.kinematics.arrays import Array

UNSEEN = 1e-6
"""Effect of a parameter's typical change on any coordinate, over the length of the arm, below which it is not seen."""


def moves(problem: Problem, slopes: Array) -> NDArray[np.bool_]:
    """Return which parameters move any marker, shape (P,), of derivatives of errors by them [m], shape (M, P)."""
    return np.asarray(np.abs(slopes).max(axis=0) * problem.every.typical > UNSEEN * problem.length)


def cannot_see(name: str, recordings: Sequence[Recording]) -> str:
    """Return why recordings of this kind do not see a parameter, or nothing."""
    if all(one.kind == "static" for one in recordings):
        if "damping" in name:
            return "an arm at rest does not show its damping"
        if name.split(".")[-1] in ("mass", "payload", "gravity"):
            return "an arm at rest shows its weight alone, and only where gravity bends it"
    if name.startswith("actuation.") and all(one.rig.actuation.drive == "none" for one in recordings):
        return "no channel drives anything"
    return ""

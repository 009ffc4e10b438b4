"""Which parameters the markers of recordings move with, why some do not, and how much of the motion a fit explains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from contarm_sim.identify.fitted import Fit
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.search.residuals import Problem
from contarm_sim.kinematics.arrays import Array

UNSEEN = 1e-6
"""Effect of a parameter's typical change on any coordinate, over the length of the arm, below which it is not seen."""

POOR = 0.25
"""Share of the markers' scatter that a fit leaves over, above which it explains too little."""

POOR_LENGTH = 0.02
"""The same over the length of the arm: markers that hardly move are not explained better by another fit."""


def moves(problem: Problem, slopes: Array) -> NDArray[np.bool_]:
    """Return which parameters move any marker, shape (P,), of derivatives of errors by them [m], shape (M, P)."""
    return np.asarray(np.abs(slopes).max(axis=0) * problem.every.typical > UNSEEN * problem.length)


def cannot_see(name: str, recordings: Sequence[Recording]) -> str:
    """Return why recordings of this kind do not see a parameter, or nothing."""
    field = next((part for part in ("damping", "mass", "payload", "gravity") if part in name.split(".")), "")
    field = "damping" if "damping" in name else field
    if field == "payload" and all(one.payload is not None for one in recordings):
        return "the recording says what the tip carries, in place of the arm"
    if field == "gravity" and all(one.rig.gravity is not None for one in recordings):
        return "the rig says what gravity is, in place of the arm"
    if all(one.kind == "static" for one in recordings):
        if field == "damping":
            return "an arm at rest does not show its damping"
        if field:
            return "an arm at rest shows its weight alone, and only where gravity bends it"
    if name.startswith("actuation.") and all(one.rig.actuation.drive == "none" for one in recordings):
        return "no channel drives anything"
    if name.startswith("actuation.slack") and all(one.rig.actuation.drive == "windings" for one in recordings):
        return "every tendon stays taut, or slack, whatever it is: try a start with more, or less"
    return ""


def scatter(recordings: Sequence[Recording]) -> float:
    """Return how far markers are from their own means [m], root mean square distance."""
    squares = [one.positions - np.nanmean(one.positions, axis=0) for one in recordings]
    every = np.concatenate([(one**2).sum(axis=-1).ravel() for one in squares])
    return float(np.sqrt(np.nanmean(every)))


def explains_little(fit: Fit) -> str:
    """Return what to say of a fit that leaves much of the markers' motion over, or nothing."""
    for left in fit.left:
        rows = ~left.held_out
        rms, moved = left.rms(rows), scatter([left.recording.part(rows)])
        if rms > max(POOR * moved, POOR_LENGTH * fit.arm.length):
            of = f" of {left.recording.name}" if len(fit.left) > 1 else ""
            return (
                f"this fit leaves over {100 * rms / moved:.0f} % of the markers' motion{of} ({1e3 * rms:.3g} of "
                f"{1e3 * moved:.3g} mm): its values may be far from the true ones: try more starts, or bounds"
            )
    return ""

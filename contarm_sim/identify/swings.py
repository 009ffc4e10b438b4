"""Free swings of a replay: frequency and damping, measured and simulated, by one measure from one start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.errors import InputError
from contarm_sim.identify.recording import Recording
from contarm_sim.identify.ringdown import Ringdown, ringdown
from contarm_sim.kinematics.arrays import Array


@dataclass(frozen=True, eq=False, repr=False)
class Swing(Shown):
    """One release, seen at the last marker along the line that it swings on.

    Attributes:
        block: of the recording.
        rows: its samples from where the hand has let go, shape (T,).
        measured, simulated: the damped cosines.
    """

    block: str
    rows: NDArray[np.intp]
    measured: Ringdown
    simulated: Ringdown

    @property
    def frequency_percent(self) -> float:
        """How much faster the simulated arm swings [%]."""
        return 100 * (self.simulated.frequency / self.measured.frequency - 1)

    @property
    def damping_percent(self) -> float:
        """How much faster its swing fades [%]."""
        return 100 * (self.simulated.damping / self.measured.damping - 1)


def swings_of(recording: Recording, predicted: Array) -> tuple[Swing, ...]:
    """Return the free swings of a recording of which both is known, measured and predicted; none where it is driven.

    A swing that grows is left out: something moved the arm again.

    Args:
        predicted: where the markers are [m], shape (T, K, 3); NaN before the hand lets go.
    """
    if recording.kind != "motion" or recording.rig.actuation.drive != "none":
        return ()
    found = []
    for block in dict.fromkeys(recording.blocks.tolist()):
        rows = np.flatnonzero((recording.blocks == block) & np.isfinite(predicted[:, -1]).all(axis=-1))
        if not len(rows):
            continue
        time = recording.time[rows] - recording.time[rows[0]]
        try:
            measured = ringdown(time, recording.positions[rows, -1])
            simulated = ringdown(time, predicted[rows, -1], measured.direction)
        except InputError:  # too few samples, or nothing moves
            continue
        if measured.damping <= 0:  # something moved the arm again: no free swing grows
            continue
        found.append(Swing(block, rows, measured, simulated))
    return tuple(found)

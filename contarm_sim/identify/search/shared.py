"""The free parameters of several recordings together: one arm, one vector, and each recording's own rig."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.identify.freedom import Free, Freedom, free_names, freedom, meant
from contarm_sim.identify.judgement.identifiability import prior_in_vector
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

TYPICAL_TURN = 0.5
"""An angle that a fit may be wrong by [rad]; of positive parameters, a factor of exp(0.5)."""

TYPICAL_SHIFT = 0.05
"""A shift that it may be wrong by, over the length of the arm."""


@dataclass(frozen=True)
class Shared:
    """P parameters that R recordings share.

    Attributes:
        arm: where it starts from.
        rigs: likewise, one for each recording.
        free: the parameters, stars written out.
        freedoms: of each recording: the parameters that it has.
        places: of a recording's parameters among all.
        units, logarithmic: of each parameter, as of `Freedom`.
        start, start_values: the vector that it starts from and its values, shape (P,).
        low, high: bounds of the vector, shape (P,).
        typical: size of a change of the vector that is neither small nor large, shape (P,).
    """

    arm: Arm
    rigs: tuple[Rig, ...]
    free: tuple[Free, ...]
    freedoms: tuple[Freedom | None, ...]
    places: tuple[NDArray[np.intp], ...]
    units: tuple[str, ...]
    logarithmic: tuple[bool, ...]
    start: Array
    start_values: Array
    low: Array
    high: Array
    typical: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return tuple(one.name for one in self.free)

    def of_vector(self, vector: Array) -> Array:
        """Return the parameters' values of a vector, SI units, shape (..., P)."""
        inside = np.where(self.logarithmic, np.minimum(vector, 700.0), 0.0)
        values = np.where(self.logarithmic, np.exp(inside), vector)
        return np.where(vector == self.start, self.start_values, values)  # to the bit: unchanged is unchanged

    def applied(self, vector: Array) -> tuple[Arm, tuple[Rig, ...]]:
        """Return the arm and the rigs of a vector, shape (P,).

        Raises:
            InputError: values that an arm or a rig cannot have.
        """
        values, arm, rigs = self.of_vector(vector), self.arm, list(self.rigs)
        for place, (own, places) in enumerate(zip(self.freedoms, self.places, strict=True)):
            if own is not None:
                arm, rigs[place] = own.applied(values[places])
        return arm, tuple(rigs)


def shared(arm: Arm, recordings: Sequence[Recording], free: Sequence[Free | str]) -> Shared:
    """Return the free parameters of an arm and of the rigs of its recordings.

    Raises:
        InputError: as `freedom`; a name is known where one recording's rig has it. Recordings that start from
            different values of it, or whose units differ.
    """
    given = [one if isinstance(one, Free) else Free(name=one) for one in ([free] if isinstance(free, str) else free)]
    known = [free_names(arm, recording.rig) for recording in recordings]
    together = dict.fromkeys(name for names in known for name in names)
    written = [replace(one, name=name) for one in given for name in meant(one.name, arm, together)]
    if not written:
        freedom(arm, recordings[0].rig, written)  # raises: nothing is free
    own: list[Freedom | None] = []
    for names, recording in zip(known, recordings, strict=True):
        kept = [one for one in written if one.name in names]
        own.append(freedom(arm, recording.rig, kept) if kept else None)
    every: dict[str, tuple[Free, str, bool, float, float, float, float]] = {}
    for one in own:
        if one is not None:
            low, high = one.bounds()
            values = one.values()
            start = one.vector(values)
            for row in zip(one.free, one.units, one.logarithmic, start, values, low, high, strict=True):
                first = every.setdefault(row[0].name, row)
                if first[1] != row[1] or not np.isclose(first[4], row[4], rtol=1e-9, atol=1e-12):
                    said = f"{first[4]:g} {first[1]} in one recording, {row[4]:g} {row[1]} in another"
                    raise InputError(row[0].name, said, "one start and unit in all: a fit finds one value for all")
    order = {name: place for place, name in enumerate(every)}
    places = tuple(np.array([order[name] for name in one.names] if one else [], dtype=np.intp) for one in own)
    frees, units, logarithmic, starts, own_values, lows, highs = zip(*every.values(), strict=True)
    rows = zip(units, logarithmic, starts, lows, highs, strict=True)
    typical = [_typical(arm.length, *row) for row in rows]
    return Shared(
        arm, tuple(one.rig for one in recordings), frees, tuple(own), places, units, logarithmic, np.array(starts),
        np.array(own_values), np.array(lows), np.array(highs), np.array(typical),
    )  # fmt: skip


def prior_of(every: Shared, place: int) -> tuple[float, float]:
    """Return the mean and the spread of a parameter's prior in the vector, see `prior_in_vector`.

    Raises:
        InputError: a mean that the parameter cannot have.
    """
    return prior_in_vector(every.free[place], every.logarithmic[place], float(every.start[place]))


def _typical(length: float, unit: str, logarithmic: bool, start: float, low: float, high: float) -> float:
    """Return the size of a change of one number of the vector that is neither small nor large."""
    if logarithmic:
        usual = TYPICAL_TURN
    elif unit == "m":
        usual = TYPICAL_SHIFT * length
    elif unit == "rad":
        usual = TYPICAL_TURN
    else:
        usual = 0.5 * abs(start) or 0.1
    return float(min(usual, 0.25 * (high - low)))

"""Legs of motions: what of a pass is to be flown, alone or with many others at once, to the same bits."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.control.corrections import Corrections
from contarm_sim.control.feedback import Seen
from contarm_sim.engine.backends import together
from contarm_sim.engine.index import rows
from contarm_sim.engine.layout import layout
from contarm_sim.engine.plants import Plants
from contarm_sim.engine.recorder import Recorder
from contarm_sim.errors import ContarmError, InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.motion.stepping_loop import EVERY, Pass, Snapshot

FEWEST = 4
"""Fewest arms that fly faster together than one after the other."""


@dataclass(frozen=True)
class Leg:
    """Ticks of a pass, from `start` to before `stop`; its plant is where they start from."""

    one: Pass
    start: int
    stop: int

    @property
    def kind(self) -> tuple[Any, ...]:
        """What legs that are flown together have in common."""
        plant = self.one.plant
        return self.one.substeps, plant.actuation, layout(plant.own)


@dataclass(frozen=True)
class Flown:
    """A leg that was flown.

    Attributes:
        recorder: what was seen.
        count: of the ticks recorded, fewer than the leg's if Ctrl-C came.
        seconds: that it took; of legs flown together, its share.
    """

    recorder: Recorder
    count: int
    seconds: float


Flight = Generator[Leg, Flown, Any]
"""A motion that asks for legs, one after the other, and returns what came of them."""


def alone(flight: Flight, on_tick: Callable[[int], object] | None = None) -> Any:
    """Fly all legs of a motion by themselves; return what it returns."""
    try:
        leg = next(flight)
        while True:
            try:
                flown = _fly(leg, on_tick)
            except ContarmError as error:
                leg = flight.throw(error)
            else:
                leg = flight.send(flown)
    except StopIteration as end:
        return end.value


def _fly(leg: Leg, on_tick: Callable[[int], object] | None) -> Flown:
    recorder, begin = Recorder(leg.one.plant, leg.stop - leg.start), time.perf_counter()
    count = leg.one.run(recorder, leg.start, leg.stop, on_tick)
    return Flown(recorder, count, time.perf_counter() - begin)


def fly_together(legs: Sequence[Leg], threads: int, backend: str) -> list[Flown | ContarmError]:
    """Fly legs of one kind at once; an arm that cannot go on gives its error, and leaves the others alone.

    Raises:
        KeyboardInterrupt: Ctrl-C.
    """
    if len(legs) < FEWEST and backend == "cpu":
        return [_by_itself(leg) for leg in legs]
    return Formation(legs, together([leg.one.plant for leg in legs], threads, backend)).fly()


def _by_itself(leg: Leg) -> Flown | ContarmError:
    try:
        flown = _fly(leg, None)
    except ContarmError as error:
        return error
    if flown.count < leg.stop - leg.start:
        raise KeyboardInterrupt
    return flown


class Formation:
    """Legs of one kind, flown together: arrays have an axis of arms, B of them, with n muscles.

    Args:
        legs: what is flown.
        plants: their arms, where they start from, in the same order.
    """

    def __init__(self, legs: Sequence[Leg], plants: Plants) -> None:
        self._legs, self._plants = legs, plants
        self._errors: dict[int, ContarmError] = {}
        self._ticks = np.array([leg.stop - leg.start for leg in legs])
        own = [slice(leg.start, leg.stop) for leg in legs]
        muscles = len(legs[0].one.plan.start)
        self._corrections = Corrections([leg.one.feedback for leg in legs], own, muscles)
        self._gain = np.array([leg.one.gain for leg in legs])
        self._low, self._high = (np.array([leg.one.limits[side] for leg in legs]) for side in (0, 1))
        self._setpoint = _ahead(legs, int(self._ticks.max()))
        first = legs[0].one.plant
        self._recorders = [Recorder(leg.one.plant, 0) for leg in legs]
        self._muscles, self._zero, self._damping = self._recorders[0].muscles, plants.zero.T, plants.damping.T
        tip = rows(first.index.tip_position)
        self._tips = plants.sensors[:, tip] if first.hosted else plants.centres[:, -1]
        most, count = int(self._ticks.max()), len(legs)
        self._sensed = np.empty((most, count, first.model.nsensordata))
        self._stations = np.empty((most, count, *first.centres.shape))
        self._sent = np.empty((most, count, muscles))
        self._first, self._rate = np.array([leg.start for leg in legs]), np.array([leg.one.rate for leg in legs])

    def fly(self) -> list[Flown | ContarmError]:
        """Take all ticks; return what came of each leg."""
        begin = time.perf_counter()
        with np.errstate(all="ignore"):  # arms that are no longer looked at
            for tick in range(int(self._ticks.max())):
                if not self._tick(tick):
                    break
        share = (time.perf_counter() - begin) / len(self._legs)
        return [self._errors.get(place) or self._flown(place, share) for place in range(len(self._legs))]

    def _tick(self, tick: int) -> bool:
        """Take one tick of all arms that are still going, see `Pass.run`; return whether any is."""
        plants, corrections, substeps = self._plants, self._corrections, self._legs[0].one.substeps
        going = self._ticks > tick
        going[list(self._errors)] = False
        if not going.any():
            return False
        places = None if going.all() else np.flatnonzero(going)
        if tick % EVERY == 0:  # as legs start at multiples of it
            self._snapshots(tick, going)
            self._fail(corrections.failed)
        if plants.turning:
            plants.stiffen_twist()
        setpoint = self._setpoint[tick]
        ahead = self._setpoint[tick + 1] - setpoint
        self._sent[tick] = self._send(setpoint)
        plants.step(1, places, check=False)
        self._sensed[tick] = plants.sensors
        self._stations[tick] = plants.centres
        if corrections:
            corrections.update(tick, self._look(), self._gain, going)
            self._fail(corrections.failed)
        for k in range(1, substeps):
            self._send(setpoint + k / substeps * ahead)
            plants.step(1, places, check=False)
        if plants.check((self._first + tick) / self._rate):
            self._fail(plants.failed)
        return True

    def _fail(self, errors: Mapping[int, ContarmError]) -> None:
        """Note errors of arms that had none before: alone, the first ends the motion."""
        self._errors = {**errors, **self._errors}

    def _send(self, setpoint: Array) -> Array:
        """Send set-points, shape (B, n), corrected and limited, to the engine; return what was sent."""
        sent = setpoint + self._corrections.value
        outside = ~((self._low <= sent) & (sent <= self._high))
        if outside.any():
            for place in np.flatnonzero(np.isnan(sent).any(axis=1)).tolist():
                error = InputError("feedback.value", "not a number", "finite corrections of the controls")
                self._errors.setdefault(place, error)
            sent = np.where(outside, np.minimum(np.maximum(sent, self._low), self._high), sent)
        self._plants.send(sent)
        return sent

    def _look(self) -> Seen:
        """Return what the feedbacks see of all arms."""
        sensed = np.ascontiguousarray(self._plants.sensors[:, self._muscles].T)
        lengths, speeds, forces = sensed.reshape(3, -1, len(self._legs))
        pulls = -forces
        seen: Any = (lengths + self._zero, speeds, self._damping * speeds + pulls, pulls, self._tips)
        return Seen(*seen)

    def _snapshots(self, tick: int, going: NDArray[np.bool_]) -> None:
        states, memories = self._plants.state.copy(), self._corrections.memories()
        for place in np.flatnonzero(going).tolist():
            leg = self._legs[place]
            leg.one.snapshots.append(Snapshot(leg.start + tick, states[place], memories[place]))

    def _flown(self, place: int, seconds: float) -> Flown:
        recorder, count = self._recorders[place], int(self._ticks[place])
        recorder.sensed, recorder.stations = self._sensed[:count, place], self._stations[:count, place].copy()
        self._legs[place].one.setpoint = self._sent[:count, place].copy()
        return Flown(recorder, count, seconds)


def _ahead(legs: Sequence[Leg], most: int) -> Array:
    """Return set-points of all ticks and of the one after, shape (most + 1, B, n); the last goes on for good."""
    out = np.empty((most + 1, len(legs), len(legs[0].one.plan.start)))
    for place, leg in enumerate(legs):
        own = leg.one.plan.setpoint[leg.start : leg.stop + 1]
        out[: len(own), place] = own
        out[len(own) :, place] = own[-1]
    return out

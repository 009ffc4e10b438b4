"""The stepping loop: set-points to the engine, what it senses to the feedback and the recording, and nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from contarm_sim.control.feedback import Feedback, Memory, Seen
from contarm_sim.control.plan import Plan
from contarm_sim.engine.divergence import FATAL, stepping_settings
from contarm_sim.engine.index import rows
from contarm_sim.engine.moved import STATE
from contarm_sim.engine.plant import Plant
from contarm_sim.engine.recorder import Recorder
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array

EVERY = 25
"""Control ticks between snapshots."""


@dataclass(frozen=True)
class Snapshot:
    """All that a motion goes on from: control tick, engine state, and what the feedback has summed up."""

    tick: int
    state: Array
    memory: Memory | None


@dataclass
class Pass:
    """One motion on its way.

    Attributes:
        plant: the arm, in the state that the motion starts from.
        plan: set-points of all samples.
        limits: lowest and highest control of each muscle, shape (n,).
        feedback: corrects them, or None.
        rate: control ticks per second [Hz].
        substeps: engine steps per control tick.
        snapshots: taken every `EVERY` ticks, from the first on.
        setpoint: controls sent at the ticks of the last `run`, shape (ticks, n).
    """

    plant: Plant
    plan: Plan
    limits: tuple[Array, Array]
    feedback: Feedback | None
    rate: float
    substeps: int
    snapshots: list[Snapshot] = field(default_factory=list)
    setpoint: Array = field(default_factory=lambda: np.empty((0, 0)))

    @property
    def gain(self) -> float:
        """What the feedback is called with: tick over time constant."""
        return 0.0 if self.feedback is None else 1 / (self.rate * self.feedback.time)

    def run(self, recorder: Recorder, start: int, stop: int, on_tick: Callable[[int], object] | None = None) -> int:
        """Step from tick `start` to before `stop`; return the number of ticks recorded, fewer if Ctrl-C ended it.

        `mj_step` leaves poses and forces of the time that it started from, so those of a tick's first step belong to
        the tick. Between ticks set-points move in a straight line: a staircase would jolt the muscles by tens of
        newtons.

        Raises:
            DivergenceError: the engine met a bad state.
        """
        plant, model, data, feedback = self.plant, self.plant.model, self.plant.data, self.feedback
        self._value = None if feedback is None else feedback.value
        step, warned, (position, velocity, acceleration) = mujoco.mj_step, plant.warned, FATAL
        sensors, centres = data.sensordata, plant.centres
        sensed, stations = recorder.sensed, recorder.stations
        gain = self.gain
        send, (look, seen) = self._hand(), self._eyes(recorder)
        ramps, sent = self._ramps(start, stop), []
        rows: list[list[list[float]]] = []
        count, between = 0, range(1, self.substeps)
        try:
            for i in range(start, stop):
                if i % EVERY == 0:
                    self._snapshot(i)
                if plant.turning:
                    plant.stiffen_twist()
                if not rows:
                    rows = ramps[count : count + EVERY].tolist()[::-1]
                row = rows.pop()
                sent.append(send(row[0]))
                step(model, data)
                sensed[count] = sensors
                stations[count] = centres
                if feedback is not None:
                    look()
                    feedback.update(i, seen, gain)
                for k in between:
                    send(row[k])
                    step(model, data)
                if warned[position] or warned[velocity] or warned[acceleration]:
                    plant.check(stepping_settings(model, plant.arm), i / self.rate)
                count += 1
                if on_tick is not None:
                    on_tick(count)
        except KeyboardInterrupt:
            pass
        self.setpoint = np.array(sent[:count]).reshape(count, plant.control.shape[1])
        return count

    # Plain floats in and out of the engine's memory, in plain loops: these run every tick, where an array operation on
    # three numbers, or a list comprehension, costs as much as a tenth of a step.

    def _hand(self) -> Callable[[list[float]], list[float]]:
        """Return a function that sends set-points, corrected and limited, to the engine and returns what it sent."""
        control: Any = memoryview(self.plant.data.ctrl)[rows(self.plant.index.actuators.ravel())]
        several, count = self.plant.control.shape
        value: Any = memoryview(np.zeros(count) if self.feedback is None else self.feedback.value)  # type: ignore[arg-type]
        low, high = (limit.tolist() for limit in self.limits)
        muscles, more = range(count), [range(row * count, (row + 1) * count) for row in range(1, several)]

        def cut(control: float, muscle: int) -> float:
            if math.isnan(control):
                raise InputError("feedback.value", "not a number", "finite corrections of the controls")
            return min(max(control, low[muscle]), high[muscle])

        def send(row: list[float]) -> list[float]:
            for i in muscles:
                sent = row[i] + value[i]
                if not low[i] <= sent <= high[i]:
                    sent = cut(sent, i)
                row[i] = control[i] = sent
            for again in more:
                for i in again:
                    control[i] = row[i % count]
            return row

        return send

    def _eyes(self, recorder: Recorder) -> tuple[Callable[[], None], Seen]:
        """Return a function that brings what the feedback sees up to date, and that."""
        sensors = memoryview(self.plant.data.sensordata)[recorder.muscles]
        count = self.plant.control.shape[1]
        lengths, speeds, tensions, pulls = ([0.0] * count for _ in range(4))
        damping, zero = self.plant.damping.tolist(), self.plant.index.zero.tolist()
        muscles = [(i, count + i, 2 * count + i, damping[i], zero[i]) for i in range(count)]

        def look() -> None:
            sensed = sensors.tolist()
            for i, velocity, force, rate, straight in muscles:
                lengths[i] = sensed[i] + straight
                speeds[i] = speed = sensed[velocity]
                pulls[i] = pull = -sensed[force]
                tensions[i] = rate * speed + pull

        return look, Seen(lengths, speeds, tensions, pulls, self.plant.tip_seen)

    def _ramps(self, start: int, stop: int) -> Array:
        """Return the controls of every engine step before feedback, shape (ticks, substeps, n)."""
        setpoint = self.plan.setpoint
        ahead = np.diff(setpoint, axis=0, append=setpoint[-1:])[start:stop, None]
        ramps = setpoint[start:stop, None] + np.arange(self.substeps)[:, None] / self.substeps * ahead
        return np.asarray(ramps)

    def _snapshot(self, tick: int) -> None:
        if self.feedback is not None and self.feedback.value is not self._value:
            raise InputError("feedback.value", "another array than before", "the same one, changed in place")
        state = np.empty(self._size)
        mujoco.mj_getState(self.plant.model, self.plant.data, state, STATE)
        self.snapshots.append(Snapshot(tick, state, None if self.feedback is None else self.feedback.memory))

    @cached_property
    def _size(self) -> int:
        return mujoco.mj_stateSize(self.plant.model, STATE)

    def go_back(self, snapshot: Snapshot) -> None:
        """Go on from a snapshot of the same motion, taken with this or another number of substeps."""
        model, data = self.plant.model, self.plant.data
        mujoco.mj_setState(model, data, snapshot.state, STATE)
        mujoco.mj_forward(model, data)  # tensions, which stiffen a twisting arm
        mujoco.mj_setState(model, data, snapshot.state, STATE)
        if self.feedback is not None and snapshot.memory is not None:
            self.feedback.memory = snapshot.memory

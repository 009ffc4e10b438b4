"""The stepping loop: set-points to the engine, what it senses to the feedback and the recording, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.simulation.control import Command
from contarm_sim.simulation.feedback import Feedback, Memory, Seen
from contarm_sim.simulation.plant import Plant
from contarm_sim.simulation.recorder import Recorder

EVERY = 25
"""Control ticks between snapshots."""


@dataclass(frozen=True)
class Snapshot:
    """All that a motion goes on from: control tick, engine state, and what the feedback has summed up."""

    tick: int
    state: Array
    memory: Memory


@dataclass
class Pass:
    """One motion on its way.

    Attributes:
        plant: the arm, in the state that the motion starts from.
        orders: set-points of all samples.
        feedback: corrects them, or None.
        rate: control ticks per second [Hz].
        substeps: engine steps per control tick.
        snapshots: taken every `EVERY` ticks, from the first on.
        setpoint: controls sent at the ticks of the last `run`, shape (ticks, 3).
    """

    plant: Plant
    orders: Command
    feedback: Feedback | None
    rate: float
    substeps: int
    snapshots: list[Snapshot] = field(default_factory=list)
    setpoint: Array = field(default_factory=lambda: np.empty((0, 3)))

    def run(self, recorder: Recorder, start: int, stop: int, on_tick: Callable[[int], object] | None = None) -> int:
        """Step from tick `start` to before `stop`; return the number of ticks recorded, fewer if Ctrl-C ended it.

        `mj_step` leaves poses and forces of the time that it started from, so those of a tick's first step belong to
        the tick. Between ticks set-points move in a straight line: a staircase would jolt the muscles by tens of
        newtons.

        Raises:
            DivergenceError: the engine met a bad state.
        """
        plant, model, data, feedback = self.plant, self.plant.model, self.plant.data, self.feedback
        step, control, sensors, centres = mujoco.mj_step, data.ctrl, data.sensordata, plant.centres
        tip = centres[-1]
        sensed, stations = recorder.sensed, recorder.stations
        muscles, warned = sensors[recorder.muscles], data.warning.number
        ramps = self._ramps(start, stop)
        limits = self.orders.limits(plant.arm)
        gain = 0.0 if feedback is None else 1 / (self.rate * feedback.time)
        zero, damping = recorder.zero, float(plant.damping[0])
        settings = self._settings()
        value = None if feedback is None else feedback.value
        count = 0
        try:
            for i in range(start, stop):
                if i % EVERY == 0:
                    self._snapshot(i)
                plant.stiffen_twist()
                ramp = ramps[count]
                if value is not None:
                    ramp += value if len(ramp[0]) == 3 else np.concatenate([value, value])
                if limits is not None:
                    ramp.clip(*limits, out=ramp)
                control[:] = ramp[0]
                step(model, data)
                sensed[count] = sensors
                stations[count] = centres
                if feedback is not None:
                    # Plain floats: this runs every tick, where three numbers are not worth an array operation.
                    l1, l2, l3, v1, v2, v3, f1, f2, f3 = muscles.tolist()
                    tensions = (damping * v1 - f1, damping * v2 - f2, damping * v3 - f3)
                    feedback.update(i, Seen((l1 + zero, l2 + zero, l3 + zero), tensions, (-f1, -f2, -f3), tip), gain)
                    value = feedback.value
                for between in ramp[1:]:
                    control[:] = between
                    step(model, data)
                if any(warned.tolist()):
                    plant.check(settings)
                count += 1
                if on_tick is not None:
                    on_tick(count)
        except KeyboardInterrupt:
            pass
        self.setpoint = ramps[:count, 0, :3].copy()
        return count

    def _ramps(self, start: int, stop: int) -> Array:
        """Return the controls of every engine step before feedback, shape (ticks, substeps, nu)."""
        setpoint = self.orders.setpoint
        ahead = np.diff(setpoint, axis=0, append=setpoint[-1:])[start:stop, None]
        ramps = setpoint[start:stop, None] + np.arange(self.substeps)[:, None] / self.substeps * ahead
        return np.tile(ramps, (1, 1, self.plant.model.nu // 3))

    def _snapshot(self, tick: int) -> None:
        model, data = self.plant.model, self.plant.data
        state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_INTEGRATION))
        mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_INTEGRATION)
        self.snapshots.append(Snapshot(tick, state, None if self.feedback is None else self.feedback.memory))

    def go_back(self, snapshot: Snapshot) -> None:
        """Go on from a snapshot of the same motion, taken with this or another number of substeps."""
        model, data = self.plant.model, self.plant.data
        mujoco.mj_setState(model, data, snapshot.state, mujoco.mjtState.mjSTATE_INTEGRATION)
        mujoco.mj_forward(model, data)  # tensions, which stiffen a twisting arm
        mujoco.mj_setState(model, data, snapshot.state, mujoco.mjtState.mjSTATE_INTEGRATION)
        if self.feedback is not None and snapshot.memory is not None:
            self.feedback.memory = snapshot.memory

    def _settings(self) -> dict[str, Any]:
        option = self.plant.model.opt
        return {
            "timestep": option.timestep,
            "integrator": mujoco.mjtIntegrator(option.integrator).name,
            "servo_stiffness": self.plant.arm.servo_stiffness,
        }

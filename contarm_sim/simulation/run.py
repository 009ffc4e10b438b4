"""Motion: drive the simulated arm along bends at a fixed control rate and record it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.mjcf import TIMESTEP
from contarm_sim.simulation.control import Command, Controller, command
from contarm_sim.simulation.feedback import Feedback, Seen, feedback_for
from contarm_sim.simulation.plan import plan_motion
from contarm_sim.simulation.plant import Plant, engine_room
from contarm_sim.simulation.recorder import Recorder
from contarm_sim.simulation.samples import Samples
from contarm_sim.simulation.solver import Solver

CONTROL_RATE = 100.0
"""Control ticks, and samples, per second [Hz]."""


@dataclass(frozen=True)
class Stepping:
    """How the engine steps: time step [s] and integrator."""

    timestep: float = TIMESTEP
    integrator: mujoco.mjtIntegrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST

    def substeps(self, rate: float) -> int:
        """Return engine steps per control tick.

        Raises:
            InputError: the tick is no whole number of steps.
        """
        steps = 1 / (rate * self.timestep)
        if round(steps) < 1 or abs(steps - round(steps)) > 1e-6:
            raise InputError(
                "timestep", f"{self.timestep:g} s", f"a whole fraction of the control period, {1 / rate:g} s"
            )
        return round(steps)


ACCURATE = Stepping()
FAST = Stepping(0.01, mujoco.mjtIntegrator.mjINT_IMPLICITFAST)


@dataclass(frozen=True)
class Run:
    """A recorded motion.

    Attributes:
        samples: the recorded states, one a control tick.
        real_time_factor: simulated over wall-clock time of the stepping loop.
        interrupted: whether Ctrl-C ended it early; what was recorded until then is kept.
    """

    samples: Samples
    real_time_factor: float
    interrupted: bool


def simulate(
    arm: Arm,
    target: Array,
    bend: Array,
    controller: Controller = "servo",
    rate: float = CONTROL_RATE,
    stepping: Stepping = ACCURATE,
    on_tick: Callable[[int], object] | None = None,
) -> Run:
    """Follow bends [rad], shape (T, 2), one a control tick, starting at rest in the first.

    Args:
        target: the tip positions they stand for [m], shape (T, 3); passed through.
        rate: control ticks per second [Hz].
        on_tick: called with the number of samples recorded so far, for progress.

    The same input gives bit-identical samples.

    Raises:
        DivergenceError: the engine met a bad state; nothing is returned.
        ConvergenceError: no rest pose to start from.
        InputError: arrays of other shapes, bends of pi or more, a bend that pulling muscles cannot hold, or a time
            step that does not divide the tick.
    """
    if not rate > 0:
        raise InputError("rate", rate, "a positive number [Hz]")
    bend, target = arc.as_bend(bend), as_vectors(target, 3, "target")
    if bend.ndim != 2 or target.shape[:-1] != bend.shape[:-1] or not len(bend):
        raise InputError("target", f"of shape {target.shape} beside bend of shape {bend.shape}", "(T, 3) and (T, 2)")
    substeps = stepping.substeps(rate)
    if controller == "tip":
        orders = plan_motion(arm, bend, target, 1 / rate)
    else:
        orders = command(arm, bend, controller, period=1 / rate)
    plant = Plant(arm, orders.pull_only, stepping.timestep, stepping.integrator, orders.actuation)
    feedback = feedback_for(arm, orders, bend, target)
    recorder, setpoint = Recorder(plant, len(bend)), np.empty((len(bend), 3))
    with engine_room():
        plant.reset(bend[0])
        Solver(plant)(orders.start)
        plant.data.time = 0.0
        start = time.perf_counter()
        count, interrupted = _loop(plant, recorder, orders, feedback, setpoint, rate, substeps, on_tick)
        elapsed = time.perf_counter() - start
    samples = recorder.samples(count, np.arange(len(bend)) / rate, target, bend, setpoint)
    return Run(samples, max(count - 1, 0) / rate / elapsed, interrupted)


def _loop(
    plant: Plant,
    recorder: Recorder,
    orders: Command,
    feedback: Feedback | None,
    setpoint: Array,
    rate: float,
    substeps: int,
    on_tick: Callable[[int], object] | None,
) -> tuple[int, bool]:
    """Step and record.

    `mj_step` leaves poses and forces of the time that it started from, so those of a tick's first step belong to the
    tick. Between ticks set-points move in a straight line: a staircase would jolt the muscles by tens of newtons.
    """
    model, data, control = plant.model, plant.data, plant.control
    seen = Seen(recorder.lengths, recorder.tensions, recorder.pulls, recorder.tip)
    settings = {"timestep": model.opt.timestep, "integrator": mujoco.mjtIntegrator(model.opt.integrator).name}
    settings["servo_stiffness"] = plant.arm.servo_stiffness
    ahead = np.diff(orders.setpoint, axis=0, append=orders.setpoint[-1:])
    ramps = orders.setpoint[:, None] + np.arange(substeps)[:, None] / substeps * ahead[:, None]
    limits = orders.limits(plant.arm)
    gain = 0.0 if feedback is None else 1 / (rate * feedback.time)
    count = 0
    try:
        for i, ramp in enumerate(ramps):
            if feedback is not None:
                ramp += feedback.value
            if limits is not None:
                ramp.clip(*limits, out=ramp)
            plant.stiffen_twist()
            control[:] = setpoint[i] = ramp[0]
            mujoco.mj_step(model, data)
            recorder.take(i)
            if feedback is not None:
                feedback.update(i, seen, gain)
            for between in ramp[1:]:
                control[:] = between
                mujoco.mj_step(model, data)
            plant.check(settings)
            count = i + 1
            if on_tick is not None:
                on_tick(count)
    except KeyboardInterrupt:
        return count, True
    return count, False

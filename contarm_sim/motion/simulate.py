"""Motion: drive the simulated arm along bends at a fixed control rate and record it, in steps that are short enough.

Unless a step is given, it is found: the longest that cannot blow up, halved until the recorded tips would hardly move
if it were halved once more. On slow paths that is checked where the tip accelerates most, for some percent of the
time; where the step matters, or something rubs, the whole motion is simulated again.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from contarm_sim.control.command import Command, Controller, command
from contarm_sim.control.feedback import feedback_for
from contarm_sim.control.tip_plan import plan_motion
from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.engine.recorder import Recorder
from contarm_sim.errors import DivergenceError, InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.model.arm import Arm
from contarm_sim.motion.loop import EVERY, Pass, Snapshot
from contarm_sim.motion.motion_extrapolation import coarser, extrapolated
from contarm_sim.motion.stepping import ACCURATE, FAST, Stepping, stable_substeps
from contarm_sim.results.samples import Samples
from contarm_sim.statics.solver import Solver

__all__ = ["ACCURATE", "CONTROL_RATE", "FAST", "STEP_LIMIT", "Run", "Stepping", "simulate"]

CONTROL_RATE = 100.0
"""Control ticks, and samples, per second [Hz]."""

STEP_LIMIT = 1e-3
"""Largest error [lengths] of the tip that the time step may make."""

_WANTED, _QUIET = 0.4 * STEP_LIMIT, 0.2 * STEP_LIMIT
"""Error of the step [lengths] that is aimed at; seen in one window, that is taken to be small everywhere."""

_MOST_STEPS = 400_000
"""Engine steps that one motion is given at most to reach the limit."""


@dataclass(frozen=True)
class Run:
    """A recorded motion.

    Attributes:
        samples: the recorded states, one a control tick.
        real_time_factor: simulated over wall-clock time of the stepping loop.
        interrupted: whether Ctrl-C ended it early; what was recorded until then is kept.
        timestep: engine step [s].
        step_error: how far the step puts the tip off [m], estimated from another step; shape (T,), NaN where it was not
            compared. None: nowhere.
        extrapolated: whether the samples are those of infinitely many links, as two chains tell.
    """

    samples: Samples
    real_time_factor: float
    interrupted: bool
    timestep: float
    step_error: Array | None = None
    extrapolated: bool = False


def simulate(
    arm: Arm,
    target: Array,
    bend: Array,
    controller: Controller = "servo",
    rate: float = CONTROL_RATE,
    stepping: Stepping | None = None,
    on_tick: Callable[[int], object] | None = None,
    check_step: bool | None = None,
    extrapolate: bool = False,
) -> Run:
    """Follow bends [rad], shape (T, 2), one a control tick, starting at rest in the first.

    Args:
        target: the tip positions they stand for [m], shape (T, 3); passed through.
        rate: control ticks per second [Hz].
        stepping: how the engine steps; default found for this arm and motion, so that the step's own error stays below
            `STEP_LIMIT` if 400,000 steps are enough for that.
        on_tick: called with the number of samples recorded so far, for progress; starts again with each simulation.
        check_step: estimate the step's error; default only where the step is found.
        extrapolate: simulate a chain of half the links too, and return what both say of infinitely many.

    The same input gives bit-identical samples.

    Raises:
        DivergenceError: the engine met a bad state; nothing is returned.
        ConvergenceError: no rest pose to start from.
        InputError: arrays of other shapes, bends of pi or more, a bend that pulling muscles cannot hold, a time
            step that does not divide the tick, or an arm that no step suits.
    """
    if not rate > 0:
        raise InputError("rate", rate, "a positive number [Hz]")
    bend, target = arc.as_bend(bend), as_vectors(target, 3, "target")
    if bend.ndim != 2 or target.shape[:-1] != bend.shape[:-1] or not len(bend):
        raise InputError("target", f"of shape {target.shape} beside bend of shape {bend.shape}", "(T, 3) and (T, 2)")
    if extrapolate:
        half = replace(arm, links=coarser(arm.links))
        given = (target, bend, controller, rate, stepping, on_tick, check_step)
        fine = simulate(arm, *given)
        return fine if fine.interrupted else _both(fine, simulate(half, *given))
    substeps = None if stepping is None else stepping.substeps(rate)
    if controller == "tip":
        orders = plan_motion(arm, bend, target, 1 / rate)
    else:
        orders = command(arm, bend, controller, period=1 / rate)
    motion = _Motion(arm, target, bend, orders, rate, stepping or ACCURATE, on_tick)
    with engine_room():
        if substeps is None:
            return motion.found()
        return motion.checked(substeps) if check_step else motion.run(substeps)


def _both(fine: Run, coarse: Run) -> Run:
    spent = sum(len(run.samples) / run.real_time_factor for run in (fine, coarse))
    samples = extrapolated(fine.samples, coarse.samples)
    interrupted = fine.interrupted or coarse.interrupted
    error = None if fine.step_error is None else fine.step_error[: len(samples)]
    return Run(samples, len(samples) / spent, interrupted, fine.timestep, error, extrapolated=True)


class _Motion:
    """One motion, simulated in steps of one length or another."""

    def __init__(
        self,
        arm: Arm,
        target: Array,
        bend: Array,
        orders: Command,
        rate: float,
        stepping: Stepping,
        on_tick: Callable[[int], object] | None,
    ) -> None:
        self._target, self._bend, self._orders, self._rate, self._on_tick = target, bend, orders, rate, on_tick
        self.arm, self._integrator = arm, stepping.integrator
        self._plant = Plant(arm, orders.pull_only, None, stepping.integrator, orders.actuation)
        self._plant.reset(bend[0])
        Solver(self._plant)(orders.start)
        self._start = self._plant.data.qpos.copy()
        self._snapshots: list[Snapshot] = []

    def _pass(self, substeps: int) -> Pass:
        """Return the motion at its beginning."""
        plant = self._plant
        plant.restart(self._start, self._orders.start)
        plant.model.opt.timestep = 1 / (self._rate * substeps)
        feedback = feedback_for(self.arm, self._orders, self._bend, self._target)
        return Pass(plant, self._orders, feedback, self._rate, substeps)

    def run(self, substeps: int) -> Run:
        """Simulate all of it in so many steps per control tick."""
        count = len(self._bend)
        one, recorder = self._pass(substeps), Recorder(self._plant, count)
        start = time.perf_counter()
        done = one.run(recorder, 0, count, self._on_tick)
        elapsed = time.perf_counter() - start
        self._snapshots = one.snapshots
        samples = recorder.samples(done, np.arange(count) / self._rate, self._target, self._bend, one.setpoint)
        return Run(samples, max(done - 1, 0) / self._rate / elapsed, done < count, 1 / (self._rate * substeps))

    def found(self) -> Run:
        """Simulate in steps that are short enough.

        Raises:
            InputError: no step suits this arm.
            DivergenceError: the arm blows up however short the step is.
        """
        farthest = self._bend[np.hypot(*self._bend.T).argmax()]
        substeps = stable_substeps(self._plant, self._rate, farthest[None])
        while True:
            try:
                return self.checked(substeps, refine=True)
            except DivergenceError:
                substeps *= 4
                if substeps * len(self._bend) > _MOST_STEPS:
                    raise

    def checked(self, substeps: int, refine: bool = False) -> Run:
        """Simulate in so many steps per control tick, or in more if `refine`, and estimate the step's error.

        The engine's error is of first order in the step, so that of the finer of two runs is their difference over the
        ratio of their steps less one. With dry friction it is of no order: there it is taken to be twice the
        difference, and where that no longer falls, shorter steps are not tried.
        """
        run = self.run(substeps)
        limit = self.arm.length * _WANTED * (2 if self._rubs else 1)
        error = self._in_a_window(run, substeps)
        quiet = np.nanmax(error, initial=0.0) <= self.arm.length * _QUIET
        if run.interrupted or (quiet and not self._rubs):
            return replace(run, step_error=error)
        before = np.full(len(run.samples), np.inf)
        while True:
            ratio = int(np.clip(math.ceil(np.nanmax(error) / limit), 2, 8)) if refine else 2
            if substeps * ratio * len(self._bend) > _MOST_STEPS:
                return replace(run, step_error=error)
            finer = self.run(substeps * ratio)
            if finer.interrupted:
                return replace(run, interrupted=True, step_error=error)
            off = np.linalg.norm(run.samples.stations[:, -1] - finer.samples.stations[:, -1], axis=-1)
            if not refine:
                return replace(run, step_error=2 * off if self._rubs else off * ratio / (ratio - 1))
            run, error, substeps = finer, 2 * off if self._rubs else off / (ratio - 1), substeps * ratio
            if error.max() <= limit:
                return replace(run, step_error=error)
            if self._rubs and error.max() > 0.7 * before.max():
                return replace(run, step_error=np.maximum(error, before))
            before = error

    @property
    def _rubs(self) -> bool:
        """Whether dry friction, which sticks and slips, makes a window tell little of the whole."""
        return self.arm.joint_friction is not None or self.arm.muscle.braid_friction is not None

    def _in_a_window(self, run: Run, substeps: int) -> Array:
        """Estimate the step's error [m] where the tip accelerates most, by simulating that again in half the step.

        What the step did before the window has died out by its end if the arm forgets fast enough; for others the
        estimate is made larger by as much as they remember longer.
        """
        tips, count = run.samples.stations[:, -1], len(run.samples)
        error = np.full(count, np.nan)
        if count < 3:
            return error
        jolt = np.zeros(count)
        jolt[1:-1] = np.linalg.norm(np.diff(tips, 2, axis=0), axis=-1)
        hardest = max(range(len(self._snapshots)), key=lambda i: jolt[i * EVERY : (i + 1) * EVERY].max())
        before = self._snapshots[max(hardest - 1, 0)]  # what the step did before has time to show
        window = slice(before.tick, min(int(jolt.argmax()) + EVERY, count))
        again, recorder = self._pass(2 * substeps), Recorder(self._plant, window.stop - window.start)
        again.go_back(before)
        done = again.run(recorder, window.start, window.stop)
        off = np.linalg.norm(recorder.stations[:done, -1] - tips[window][:done], axis=-1)
        rate = 0.5 * self.arm.damping_time * self.arm.bend_frequency**2  # at which the slowest mode dies out
        remembered = min(1 / max(rate, 1e-9), count / self._rate)
        longer = max(1.0, remembered * self._rate / max(done, 1))
        error[window.start : window.start + done] = 2 * off * longer
        return error

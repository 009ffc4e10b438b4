"""One motion in steps of one length or another, and the step that is short enough.

Unless a step is given, it is found: the longest that cannot blow up, halved until the recorded tips would hardly move
if it were halved once more. On slow paths that is checked where the tip accelerates most, for some percent of the
time; where the step matters, or something rubs, the whole motion is simulated again.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from contarm_sim.control.base import Controller
from contarm_sim.control.feedback import Feedback, Memory
from contarm_sim.engine.plant import Plant
from contarm_sim.errors import DivergenceError
from contarm_sim.mjcf.overlaps import refuse_overlaps
from contarm_sim.model.arm import Arm
from contarm_sim.motion.legs import Flight, Leg
from contarm_sim.motion.stepping_loop import EVERY, Pass, Snapshot
from contarm_sim.motion.time_step import Stepping, stable_substeps
from contarm_sim.paths.reference import Reference
from contarm_sim.results.trajectory import STEP_LIMIT, Trajectory
from contarm_sim.statics.solver import Solver
from contarm_sim.versions import versions

_WANTED, _QUIET = 0.4 * STEP_LIMIT, 0.2 * STEP_LIMIT
"""Error of the step [lengths] that is aimed at; seen in one window, that is taken to be small everywhere."""

_REFINED = 16
"""How much shorter than the first step others are tried at most where the arm touches something: whether it sticks or
slips there, and when, may depend on any step, and then halving it does not help."""

_MOST_STEPS = 400_000
"""Engine steps that one motion is given at most to reach the limit."""


class Motion:
    """One motion, in steps of one length or another; `found`, `checked` and `run` ask for legs, see `legs`."""

    def __init__(
        self,
        arm: Arm,
        reference: Reference,
        controller: Controller,
        stepping: Stepping,
    ) -> None:
        self._reference, self._controller = reference, controller
        self.arm, self._bend, self._rate = arm, reference.bend, reference.rate
        pulls, integrator, actuation = controller.pulls_only, stepping.integrator, controller.actuation
        self._alone = alone = Plant(arm.alone, pulls, None, integrator, actuation)
        self._plan = controller.checked_plan(arm, reference, alone.control.shape[1])
        alone.reset(reference.bend[0])
        Solver(alone)(self._plan.start)
        self._start = alone.qpos.copy()
        touches = arm.world.touchable
        self._plant = Plant(arm, pulls, None, integrator, actuation, in_world=True) if touches else alone
        if touches:
            self._plant.restart(self._start, self._plan.start)
            refuse_overlaps(arm, self._plant.model, self._plant.data, "where the motion starts")
        self._snapshots: list[Snapshot] = []
        self._at_first: tuple[Feedback, Memory] | None = None

    def _pass(self, substeps: int) -> Pass:
        """Return the motion at its beginning."""
        plant, plan = self._plant, self._plan
        plant.restart(self._start, plan.start)
        plant.own.step_by(1 / (self._rate * substeps))
        feedback = self._controller.checked_feedback(self.arm, self._reference, plan)
        if feedback is not None:  # one that a controller returns again would go on from what it summed up
            self._at_first = self._at_first or (feedback, tuple(part.copy() for part in feedback.memory))
            feedback.memory = self._at_first[1]
        return Pass(plant, plan, self._controller.checked_limits(self.arm), feedback, self._rate, substeps)

    def whole(self, flight: Flight) -> Flight:
        """Fly one of the below; a feedback forgets what it has summed up, for a controller that returns it again."""
        try:
            return (yield from flight)
        finally:
            if self._at_first is not None:
                feedback, memory = self._at_first
                feedback.memory = memory

    def run(self, substeps: int) -> Flight:
        """Simulate all of it in so many steps per control tick; less of it where Ctrl-C comes."""
        reference, count, one = self._reference, len(self._bend), self._pass(substeps)
        flown = yield Leg(one, 0, count)
        done = flown.count
        self._snapshots = one.snapshots
        driven = self._controller
        return Trajectory(
            arm=self.arm, **driven.about(),
            status="finished" if done == count else "interrupted", time=reference.time[:done],
            target=reference.target[:done], bend=reference.bend[:done], setpoint=one.setpoint,
            direction=None if reference.direction is None else reference.direction[:done],
            **flown.recorder.arrays(done), timestep=1 / (self._rate * substeps),
            real_time_factor=max(done - 1, 0) / self._rate / flown.seconds, versions=versions(),
        )  # fmt: skip

    def found(self) -> Flight:
        """Simulate in steps that are short enough.

        Raises:
            InputError: no step suits this arm.
            DivergenceError: the arm blows up however short the step is.
        """
        farthest = self._bend[np.linalg.norm(self._bend, axis=1).argmax()]
        substeps = stable_substeps(self._alone, self._rate, farthest[None], self.arm.world.host)
        while True:
            try:
                return (yield from self.checked(substeps, refine=True))
            except DivergenceError:
                substeps *= 4
                if substeps * len(self._bend) > _MOST_STEPS:
                    raise

    def checked(self, substeps: int, refine: bool = False) -> Flight:
        """Simulate in so many steps per control tick, or in more if `refine`, and estimate the step's error.

        That is how far the tip is off; what becomes of free objects is not compared.

        The engine's error is of first order in the step, so that of the finer of two runs is their difference over the
        ratio of their steps less one. With dry friction it is of no order: there it is taken to be twice the
        difference, and where that no longer falls, shorter steps are not tried.
        """
        run = yield from self.run(substeps)
        touches = bool(run.contacts)
        rubs = touches or self._rubs
        limit = self.arm.length * _WANTED * (2 if rubs else 1)
        if run.status == "interrupted":
            return run
        error, whole = yield from self._in_a_window(run, substeps)
        if not whole:
            return replace(run, status="interrupted", step_error=error)
        quiet = np.nanmax(error, initial=0.0) <= self.arm.length * _QUIET
        if quiet and not rubs:
            return replace(run, step_error=error)
        before = np.full(len(run), np.inf)
        shortest = _REFINED * substeps if touches else _MOST_STEPS
        while True:
            ratio = int(np.clip(math.ceil(np.nanmax(error) / limit), 2, 8)) if refine and not touches else 2
            if substeps * ratio * len(self._bend) > _MOST_STEPS or substeps * ratio > shortest:
                return replace(run, step_error=error)
            finer = yield from self.run(substeps * ratio)
            if finer.status == "interrupted":
                return replace(run, status="interrupted", step_error=error)
            off = np.linalg.norm(run.tip - finer.tip, axis=-1)
            if not refine:
                return replace(run, step_error=2 * off if rubs else off * ratio / (ratio - 1))
            run, error, substeps = finer, 2 * off if rubs else off / (ratio - 1), substeps * ratio
            if error.max() <= limit:
                return replace(run, step_error=error)
            if rubs and error.max() > 0.7 * before.max():
                return replace(run, step_error=np.maximum(error, before))
            before = error

    @property
    def _rubs(self) -> bool:
        """Whether dry friction, which sticks and slips, makes a window tell little of the whole."""
        joints = any(section.joint_friction is not None for section in self.arm.sections)
        muscles = any(group.law.dry_friction is not None for group in self.arm.groups)
        return joints or muscles

    def _in_a_window(self, run: Trajectory, substeps: int) -> Flight:
        """Estimate the step's error [m] where the tip accelerates most, by simulating that again in half the step.

        The second value tells whether that was done; Ctrl-C may end it.

        What the step did before the window has died out by its end if the arm forgets fast enough; for others the
        estimate is made larger by as much as they remember longer.
        """
        tips, count = run.tip, len(run)
        error = np.full(count, np.nan)
        if count < 3:
            return error, True
        jolt = np.zeros(count)
        jolt[1:-1] = np.linalg.norm(np.diff(tips, 2, axis=0), axis=-1)
        hardest = max(range(len(self._snapshots)), key=lambda i: jolt[i * EVERY : (i + 1) * EVERY].max())
        before = self._snapshots[max(hardest - 1, 0)]  # what the step did before has time to show
        window = slice(before.tick, min(int(jolt.argmax()) + EVERY, count))
        again = self._pass(2 * substeps)
        again.go_back(before)
        flown = yield Leg(again, window.start, window.stop)
        done = flown.count
        off = np.linalg.norm(flown.recorder.backbones(done)[:, -1] - tips[window][:done], axis=-1)
        damping = min(section.damping_time for section in self.arm.sections)
        rate = 0.5 * damping * self.arm.bend_frequency**2  # at which the slowest mode dies out
        remembered = min(1 / max(rate, 1e-9), count / self._rate)
        longer = max(1.0, remembered * self._rate / max(done, 1))
        error[window.start : window.start + done] = 2 * off * longer
        return error, done == window.stop - window.start

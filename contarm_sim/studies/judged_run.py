"""A recorded motion beside the closed forms: its errors, what explains them, and whether that is enough."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from contarm_sim.control.base import Controller
from contarm_sim.display import Shown
from contarm_sim.errors import DivergenceError, EquilibriumError, InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import check_count
from contarm_sim.motion.lag import moved_by_motion
from contarm_sim.motion.without_objects import without_objects
from contarm_sim.results.compare import Comparison, compare
from contarm_sim.results.document import HIDDEN, INLINE, shown_if
from contarm_sim.results.summary import ErrorSummary, Spread, known_spread, spread, summarise
from contarm_sim.results.touched import ContactSummary, touched
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.studies.checks import run_checks
from contarm_sim.studies.explained import RodParts, explain
from contarm_sim.studies.timestep import TimeStep, step_summary
from contarm_sim.studies.verdict import ConstantCurvature, Verdict, constant_curvature, verdict


@dataclass(frozen=True, eq=False, repr=False)  # arrays have no single answer to ==
class JudgedRun(Shown):
    """A motion in numbers.

    Attributes:
        comparison: sample by sample.
        swing: times [s], shape (K,), and the tip's ways from its pose at rest [m], shape (K, 3); NaN where
            `motion` is None.
        errors: the comparison in numbers.
        motion: how far the arm is from its pose at rest; None where some commanded pose has no rest, or where what
            contact does is not known.
        rod: what an ideal rod explains of the shape.
        time_step: the engine's step, and its own error.
        constant_curvature: whether it holds.
        judged: whether the simulation is explained and converged, and targets are met; `interrupted` if it was.
        contact: what the arm touched; None where it can touch nothing.
        controller, real_time_factor, interrupted, extrapolated, arm: of the run.
    """

    comparison: Comparison = field(metadata=HIDDEN)
    swing: tuple[Array, Array] = field(metadata=HIDDEN)
    errors: ErrorSummary = field(metadata=INLINE)
    motion: Spread | None
    rod: RodParts = field(metadata=INLINE)
    time_step: TimeStep
    constant_curvature: ConstantCurvature
    judged: Verdict = field(metadata=INLINE)
    controller: str
    real_time_factor: float | None
    interrupted: bool
    extrapolated: bool
    arm: Arm
    contact: ContactSummary | None = field(default=None, metadata=shown_if(lambda run: run.contact is not None))


def judge_run(run: Trajectory, poses: int = 100, controller: Controller | None = None) -> JudgedRun:
    """Hold a recorded motion against the closed forms and an ideal rod.

    Of an arm that touched something, the motion is simulated again without objects: the difference is
    `contact_error`, and the other parts, with what explains them, are of that motion. On a base that moves, and of
    motions that were interrupted or cannot be repeated, contact and motion are not told apart, and neither is known.

    Args:
        poses: at about as many samples, evenly picked, the rod and the poses at rest are found.
        controller: what drove the arm: give it if it was of your own; default the one of the trajectory's name.
    """
    expect("run", run, Trajectory)
    check_count("poses", poses, 1)
    arm, interrupted, alone = run.arm, run.status == "interrupted", _alone(run, controller)
    told_apart = run.base is None or not run.contacts  # of what touches nothing, contact is exactly 0
    known = alone if alone is not None and arm.world.touchable and told_apart else None
    free = _bare(run) if alone is None else alone
    comparison = compare(run, known)
    without = comparison if known is None else compare(free)
    swing = run.time[[0, -1]], np.full((2, 3), np.nan)
    if known is not None or not run.contacts:
        with suppress(EquilibriumError):  # a pose that the loaded arm cannot rest in
            swing = moved_by_motion(free, poses, controller)
    errors, motion = summarise(run, comparison), known_spread(np.linalg.norm(swing[1], axis=-1), arm.length)
    rod, step = explain(free, without, poses).summary(arm), step_summary(run)
    to_explain = replace(errors, tip_error=spread(without.tip_error, arm.length))  # contact is known
    judged = verdict(run_checks(arm, to_explain, rod, motion, step))
    return JudgedRun(
        comparison=comparison,
        swing=swing,
        errors=errors,
        motion=motion,
        rod=rod,
        time_step=step,
        constant_curvature=constant_curvature(errors, rod, motion),
        judged=replace(judged, verdict="interrupted") if interrupted else judged,
        controller=run.controller,
        real_time_factor=run.real_time_factor,
        interrupted=interrupted,
        extrapolated=run.extrapolated,
        arm=arm,
        contact=touched(run),
    )


def _alone(run: Trajectory, controller: Controller | None) -> Trajectory | None:
    """Return a motion without objects; None where it was interrupted or cannot be repeated."""
    try:
        return without_objects(run, controller) if run.arm.world.touchable else run
    except (InputError, DivergenceError, EquilibriumError):
        return None


def _bare(run: Trajectory) -> Trajectory:
    """Return a motion as if the arm had touched nothing."""
    return replace(run, arm=run.arm.alone, contacts=None, objects=None, base=None, host=None)

"""Motion: drive the simulated arm along a reference and record it, in steps that are short enough."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import cast

from contarm_sim.control.base import Controller
from contarm_sim.control.registry import ControllerName
from contarm_sim.control.registry import controller as resolved
from contarm_sim.engine.room import engine_room
from contarm_sim.errors import InputError, Interrupted, expect
from contarm_sim.model.arm import Arm
from contarm_sim.motion.legs import Flight, alone
from contarm_sim.motion.motion_extrapolation import coarser, extrapolated
from contarm_sim.motion.step_search import Motion
from contarm_sim.motion.time_step import ACCURATE, FAST, Stepping
from contarm_sim.paths.reference import RATE, Reference
from contarm_sim.results.trajectory import STEP_LIMIT, Trajectory

__all__ = ["ACCURATE", "CONTROL_RATE", "FAST", "STEP_LIMIT", "Stepping", "simulate"]

CONTROL_RATE = RATE
"""Control ticks, and samples, per second of most references [Hz]."""


def simulate(
    arm: Arm,
    reference: Reference,
    controller: ControllerName | Controller = "servo",
    *,
    stepping: Stepping | None = None,
    on_tick: Callable[[int], object] | None = None,
    check_step: bool | None = None,
    extrapolate: bool = False,
) -> Trajectory:
    """Follow a reference, one sample a control tick, starting at rest in its first bend.

    Args:
        arm: the arm, in the world that it stands in.
        reference: times, tip positions and bends; of this arm's length.
        controller: one of `control.registry.NAMES`, or an object of your own subclass of `control.base.Controller`.
        stepping: how the engine steps; default found for this arm and motion, so that the step's own error stays below
            `STEP_LIMIT` if 400,000 steps are enough for that, and where the arm touches something, if halving the step
            helps; `Trajectory.step_error` says what came of it.
        on_tick: called with the number of samples recorded so far, for progress; starts again with each simulation.
        check_step: estimate the error of a given step; one that is found is estimated always.
        extrapolate: simulate a chain of half the links too, and return what both say of infinitely many.

    The same input gives bit-identical samples.

    Raises:
        Interrupted: Ctrl-C; carries the trajectory until then. It is a KeyboardInterrupt.
        DivergenceError: the engine met a bad state; nothing is returned.
        EquilibriumError: no rest pose to start from.
        InputError: a reference of another arm's length or without times, a bend that pulling muscles cannot hold, a
            time step that does not divide the tick, or an arm that no step suits.
    """
    chosen = checked(arm, reference, controller, stepping)
    if extrapolate:
        arm.refuse_objects("motions are extrapolated")
        half = coarser(arm)
        given = {"stepping": stepping, "on_tick": on_tick, "check_step": check_step}
        fine = simulate(arm, reference, chosen, **given)  # type: ignore[arg-type]
        try:
            return _both(fine, simulate(half, reference, chosen, **given))  # type: ignore[arg-type]
        except Interrupted as error:
            raise Interrupted(replace(_both(fine, error.trajectory), status="interrupted")) from None
    with engine_room():
        found = alone(flight(arm, reference, chosen, stepping, check_step), on_tick)
    if found.status == "interrupted":
        raise Interrupted(found)
    return cast("Trajectory", found)


def checked(
    arm: Arm, reference: Reference, controller: ControllerName | Controller, stepping: Stepping | None
) -> Controller:
    """Return the controller, if the arguments are what `simulate` takes.

    Raises:
        InputError: they are not, or do not belong together.
    """
    expect("arm", arm, Arm)
    arm.refuse_memory("simulated motions are")
    expect("reference", reference, Reference)
    reference.check_arm(arm)
    if stepping is not None:
        expect("stepping", stepping, Stepping)
    if len(reference) > 1 and not reference.moving:
        raise InputError("reference", "poses at rest, all at time 0", "one with times; poses_at_rest is for these")
    return resolved(controller)


def flight(
    arm: Arm, reference: Reference, controller: Controller, stepping: Stepping | None, check_step: bool | None
) -> Flight:
    """Prepare a motion, and return what asks for its legs and returns its trajectory."""
    substeps = None if stepping is None else stepping.substeps(reference.rate)
    motion = Motion(arm, reference, controller, stepping or ACCURATE)
    begin = motion.checked if check_step else motion.run
    return motion.whole(motion.found() if substeps is None else begin(substeps))


def _both(fine: Trajectory, coarse: Trajectory) -> Trajectory:
    spent = sum(len(each) / (each.real_time_factor or 1.0) for each in (fine, coarse))
    return replace(extrapolated(fine, coarse), real_time_factor=len(fine) / spent)

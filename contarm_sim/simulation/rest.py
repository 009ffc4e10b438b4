"""Poses of the simulated arm at rest under commanded bends, corrected as the controller in motion would."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import ConvergenceError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.simulation.control import Controller, command
from contarm_sim.simulation.feedback import Feedback, Seen, feedback_for
from contarm_sim.simulation.plan import plan_rest
from contarm_sim.simulation.plant import Plant, engine_room
from contarm_sim.simulation.recorder import Recorder
from contarm_sim.simulation.samples import Samples
from contarm_sim.simulation.solver import Solver

CORRECTIONS = 300
"""Most corrections of a set-point; a handful do at 24 links, but with few links each gains little."""


def poses_at_rest(
    arm: Arm, bend: Array, target: Array, controller: Controller = "servo", ticks: Iterable[int] | None = None
) -> Samples:
    """Return the arm's poses at rest under commanded bends [rad], shape (T, 2).

    Args:
        target: tip positions that the bends stand for [m], shape (T, 3); passed through.
        ticks: an iterable over range(T), for progress.

    Raises:
        ConvergenceError, DivergenceError: no equilibrium near the uniformly bent pose.
        InputError: a bend that pulling muscles, or pressures, cannot hold.
    """
    if controller == "tip":
        orders, ticks = plan_rest(arm, bend, target, ticks), None
    else:
        orders = command(arm, bend, controller)
    plant = Plant(arm, pull_only=orders.pull_only, actuation=orders.actuation)
    settle = Solver(plant)
    feedback = None if controller == "tip" else feedback_for(arm, orders, bend, target)
    recorder, setpoint = Recorder(plant, len(bend)), np.empty((len(bend), 3))
    with engine_room():
        for i in ticks if ticks is not None else range(len(bend)):
            plant.reset(bend[i])
            if feedback is not None:
                feedback.restart()
            try:
                setpoint[i] = _hold(plant, settle, orders.setpoint[i], feedback, i)
            except ConvergenceError as error:
                raise error.located(f"at {_described(plant, bend[i])}") from None
            mujoco.mj_forward(plant.model, plant.data)  # the sensors
            recorder.take(i)
    return recorder.samples(len(bend), np.zeros(len(bend)), target, bend, setpoint)


def _described(plant: Plant, bend: Array) -> str:
    """Say which pose failed, and what may be why."""
    angle, plane = (float(np.degrees(x)) for x in arc.to_polar(bend))
    said = f"a bend of {angle:.0f} deg towards {plane:.0f} deg"
    limit = plant.arm.muscle.blocked_force
    if not len(plant.pressure) and plant.muscle_forces.max() > 0.999 * limit and plant.model.actuator_forcelimited[0]:
        return f"{said}, where a muscle is at its limit of {limit:.0f} N"
    return f"{said} with {plant.arm.links} links"


def _hold(plant: Plant, settle: Solver, setpoint: Array, feedback: Feedback | None, index: int) -> Array:
    """Settle, and let the feedback correct the set-point until it is content; return the corrected set-point."""
    if feedback is None:
        settle(setpoint)
        return setpoint
    error = np.inf
    for _ in range(CORRECTIONS):
        settle(setpoint + feedback.value)
        used = setpoint + feedback.value
        seen = Seen(plant.muscle_lengths, plant.muscle_forces, plant.muscle_forces, plant.tip)
        feedback.update(index, seen, gain=1.0)
        error = feedback.error
        if error <= 1:
            return used
    raise ConvergenceError("the controller at rest", error, 1.0, CORRECTIONS, "of its tolerance")

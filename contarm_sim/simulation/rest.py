"""Poses of the simulated arm at rest under commanded bends, corrected as the controller in motion would."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import ConvergenceError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.simulation.control import Command, Controller, Correction, TipFeedback, command
from contarm_sim.simulation.plant import Plant, engine_room
from contarm_sim.simulation.recorder import Recorder
from contarm_sim.simulation.samples import Samples
from contarm_sim.simulation.solver import Solver

LENGTH_ERROR = 1e-9
"""Largest difference left between commanded and measured length differences [m]."""

TENSION_ERROR = 1e-3
"""Largest deviation left of the slackest muscle's tension [N]."""

BEND_CHANGE = 1e-6
"""Change of the bend at which the tip's feedback has settled [rad]."""

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
        InputError: a bend that pulling muscles cannot hold.
    """
    orders = command(arm, bend, controller)
    plant = Plant(arm, pull_only=orders.pull_only)
    settle = Solver(plant)
    recorder, setpoint = Recorder(plant, len(bend)), np.empty((len(bend), 3))
    with engine_room():
        for i in ticks if ticks is not None else range(len(bend)):
            plant.reset(bend[i])
            try:
                setpoint[i] = _hold(plant, settle, orders.setpoint[i], orders.lengths[i], orders.corrected)
                if orders.seeing:
                    setpoint[i] = _look(plant, settle, orders, i, TipFeedback(arm, bend[i : i + 1], target[i : i + 1]))
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
    if plant.muscle_tensions.max() > 0.999 * limit and plant.model.actuator_forcelimited.any():
        return f"{said}, where a muscle is at its limit of {limit:.0f} N"
    return f"{said} with {plant.arm.links} links"


def _hold(plant: Plant, settle: Solver, setpoint: Array, lengths: Array, corrected: bool) -> Array:
    """Settle, and correct the set-point until lengths and least tension are as commanded."""
    correction = Correction(plant.arm)
    settle(setpoint)
    if not corrected:
        return setpoint
    error = slack = np.inf
    for _ in range(CORRECTIONS):
        deviation = lengths - plant.muscle_lengths
        error = float(np.abs(deviation - deviation.mean()).max())
        slack = abs(float(plant.muscle_tensions.min()) - plant.arm.muscle.min_tension)
        if error <= LENGTH_ERROR and slack <= TENSION_ERROR:
            return setpoint + correction.value
        correction.update(lengths, plant.muscle_lengths, -plant.muscle_tensions, gain=1.0)
        settle(setpoint + correction.value)
    raise ConvergenceError("the length servo at rest", error, LENGTH_ERROR, CORRECTIONS, "m")


def _look(plant: Plant, settle: Solver, orders: Command, index: int, feedback: TipFeedback) -> Array:
    """Shift lengths until the tip is as near to its target as two degrees of freedom bring it."""
    change = np.inf
    for _ in range(CORRECTIONS):
        change = feedback.update(0, plant.tip, gain=0.7)
        setpoint, lengths = orders.setpoint[index] + feedback.shift, orders.lengths[index] + feedback.shift
        setpoint = _hold(plant, settle, setpoint, lengths, corrected=True)
        if change <= BEND_CHANGE:
            return setpoint
    raise ConvergenceError("the tip's feedback at rest", change, BEND_CHANGE, CORRECTIONS, "rad")

"""Poses of the simulated arm at rest under commanded bends, corrected as the controller in motion would."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from contarm_sim.control.command import Command, Controller, command
from contarm_sim.control.tip_plan import planned_rest
from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.engine.recorder import Recorder
from contarm_sim.errors import ConvergenceError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import force
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.statics import servo_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.results.samples import Samples
from contarm_sim.statics.holding import Holder
from contarm_sim.statics.solver import Solver


def poses_at_rest(
    arm: Arm, bend: Array, target: Array, controller: Controller = "servo", ticks: Iterable[int] | None = None
) -> Samples:
    """Return the arm's poses at rest under commanded bends [rad], shape (T, 2).

    Args:
        target: tip positions that the bends stand for [m], shape (T, 3); passed through.
        ticks: an iterable over range(T), for progress.

    Raises:
        ConvergenceError: no equilibrium that the arm or its muscles can hold; says why.
        InputError: a bend that pulling muscles, or pressures, cannot hold.
    """
    poses = None
    if controller == "tip":
        (orders, poses), ticks = planned_rest(arm, bend, target, ticks), None
    else:
        orders = command(arm, bend, controller)
    plant = Plant(arm, pull_only=orders.pull_only, actuation=orders.actuation)
    hold = _Hold(plant, orders, bend)
    recorder, setpoint = Recorder(plant, len(bend)), np.empty((len(bend), 3))
    with engine_room():
        for i in ticks if ticks is not None else range(len(bend)):
            plant.reset(bend[i])
            if poses is not None:
                plant.data.qpos[:] = poses[i]
            try:
                setpoint[i] = hold(i)
            except ConvergenceError as error:
                raise error.located(f"at {_described(bend[i])} with {arm.links} links") from None
            mujoco.mj_forward(plant.model, plant.data)  # the sensors
            recorder.take(i)
    return recorder.samples(len(bend), np.zeros(len(bend)), target, bend, setpoint)


def _described(bend: Array) -> str:
    angle, plane = (float(np.degrees(x)) for x in arc.to_polar(bend))
    return f"a bend of {angle:.0f} deg towards {plane:.0f} deg"


class _Hold:
    """Settles a plant under its commands: as they are, or corrected as their controller would in motion."""

    def __init__(self, plant: Plant, orders: Command, bend: Array) -> None:
        self._plant, self._orders, self._bend = plant, orders, bend
        self._settle = Solver(plant)
        self._holder = Holder(self._settle) if orders.controller in ("servo", "pressure") else None

    def __call__(self, index: int) -> Array:
        """Settle in sample `index` from the plant's pose; return the set-points that hold it."""
        plant, holder, setpoint = self._plant, self._holder, self._orders.setpoint[index]
        if holder is None:
            self._settle(setpoint)
            return setpoint
        lengths, arm = self._orders.lengths[index], plant.arm
        if len(plant.pressure):
            per_pascal = force(1.0, lengths, arm)
            holder.least_pressures = np.maximum(arm.muscle.min_pressure, arm.muscle.min_tension / per_pascal)
            holder.tensions = setpoint * per_pascal
            holder(lengths, np.linalg.qr(length_jacobian(self._bend[index], arm))[0].T)
            plant.pressure[:] = plant.control[:] = setpoint = holder.pressures()
        else:
            holder.tensions = servo_tensions(setpoint, lengths, arm)
            holder(lengths)
            plant.control[:] = setpoint = holder.setpoints()
        holder.check()
        return setpoint

"""The simulated arm at rest: the pose in which all forces balance, without waiting for it to swing out."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import ConvergenceError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.simulation.control import Controller, Correction, command
from contarm_sim.simulation.plant import Plant, engine_room
from contarm_sim.simulation.recorder import Recorder
from contarm_sim.simulation.samples import Samples
from contarm_sim.simulation.stiffness import TangentStiffness

MAX_STEP = 0.3
"""Largest change of a joint angle in one Newton step [rad]."""

RESIDUAL = 1e-9
"""Largest generalised force left at rest [N m]."""

LENGTH_ERROR = 1e-9
"""Largest difference left between commanded and measured length differences [m]."""

TENSION_ERROR = 1e-3
"""Largest deviation left of the slackest muscle's tension [N]."""

CORRECTIONS = 300
"""Most corrections of a set-point; a handful do at 24 links, but with few links each gains little."""


class Settler:
    """Moves a plant to the equilibrium near its current pose: Newton with the closed-form stiffness.

    Steps are cut to `MAX_STEP` per joint and halved until the residual falls. An equilibrium that is
    not a minimum of the energy is refused.
    """

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._stiffness = TangentStiffness(plant)

    def __call__(self, setpoint: Array, iterations: int = 60) -> float:
        """Settle under the servo set-points [m], shape (3,); return the residual [N m].

        Raises:
            ConvergenceError: the residual stayed above `RESIDUAL`, or the pose found is unstable.
        """
        data = self._plant.data
        data.ctrl[:] = setpoint
        residual = self._residual()
        for _ in range(iterations):
            K = self._stiffness()
            if residual <= RESIDUAL:
                return self._stable(K, residual)
            step = np.linalg.solve(K, data.qfrc_smooth)
            step *= min(1.0, MAX_STEP / np.abs(step).max())
            start, before = data.qpos.copy(), residual
            for _ in range(12):
                data.qpos[:] = start + step
                residual = self._residual()
                if residual < before:
                    break
                step *= 0.5
        raise ConvergenceError("settling", residual, RESIDUAL, iterations, "N m")

    def _residual(self) -> float:
        self._plant.data.qvel[:] = 0
        mujoco.mj_forward(self._plant.model, self._plant.data)
        return float(np.abs(self._plant.data.qfrc_smooth).max())

    def _stable(self, K: Array, residual: float) -> float:
        try:
            np.linalg.cholesky(K)
        except np.linalg.LinAlgError:
            softest = float(np.linalg.eigvalsh(K)[0])
            raise ConvergenceError(
                f"settling found only an unstable pose (softest mode {softest:.3g} N m/rad) and",
                residual,
                RESIDUAL,
                0,
                "N m",
            ) from None
        return residual


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
    settle = Settler(plant)
    recorder, setpoint = Recorder(plant, len(bend)), np.empty((len(bend), 3))
    with engine_room():
        for i in ticks if ticks is not None else range(len(bend)):
            plant.reset(bend[i])
            setpoint[i] = _hold(plant, settle, orders.setpoint[i], orders.lengths[i], orders.corrected)
            recorder.take(i)
    return recorder.samples(len(bend), np.zeros(len(bend)), target, bend, setpoint)


def _hold(plant: Plant, settle: Settler, setpoint: Array, lengths: Array, corrected: bool) -> Array:
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

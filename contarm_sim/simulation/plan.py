"""Set-points that bring the model's own tip to its targets: statics and dynamics of the whole chain, inverted.

Three lengths steer two of the tip's three coordinates, so each sample is a small least-squares problem: the bend at
which the tip, at rest under gravity and load, is nearest to its target. Gauss-Newton solves it with the exact
derivative of the resting tip by set-points, J_tip K^-1 (kp J_muscles^T). In motion the same problem is solved again
with what the planned joint angles take to move, inertia and damping, as forces on the resting arm (d'Alembert).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace

import mujoco
import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import ConvergenceError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.statics import least_tensions
from contarm_sim.simulation.control import Command, command
from contarm_sim.simulation.plant import Plant, engine_room
from contarm_sim.simulation.solver import Solver

STEP = 1e-7
"""Change of the bend at which a sample has converged [rad]."""

SLACK = 1e-3
"""Deviation left of the slackest muscle's tension [N]."""

ITERATIONS = 100
"""Most steps for one sample; a handful do."""

RATE = 25.0
"""Samples solved per second of motion [Hz]; splines between."""

PASSES = 2
"""Times that the moving arm's forces are found from the motion planned last."""


class TipPlan:
    """Finds set-points for one arm, sample by sample.

    Attributes:
        plant: the arm, at rest in the last sample solved.
    """

    def __init__(self, arm: Arm) -> None:
        self.plant = Plant(arm)
        self._solver = Solver(self.plant)
        self._kp = arm.servo_stiffness

    def solve(
        self, bend: Array, target: Array, setpoint: Array, forces: Array | float = 0.0, least: Array | None = None
    ) -> tuple[Array, Array]:
        """Bring the tip from its current pose as near to a target [m], shape (3,), as it gets.

        Args:
            bend: about where that is [rad], shape (2,).
            setpoint: a guess [m], shape (3,).
            forces: generalised forces on the joints [N m], shape (dofs,).
            least: tensions that the muscles keep at least [N], shape (3,); default the arm's least.

        Returns:
            the set-points [m], shape (3,), and the derivative of the tip by the bend asked for [m/rad], shape (3, 2).

        Raises:
            ConvergenceError: no pose was found.
        """
        plant, setpoint = self.plant, setpoint.copy()
        least = np.full(3, plant.arm.muscle.min_tension) if least is None else least
        self._solver.extra = forces
        spread = length_jacobian(bend, plant.arm)
        size = np.inf
        for _ in range(ITERATIONS):
            self._solver(setpoint)
            slope = self._tip_by_setpoint() @ spread
            change = np.linalg.pinv(slope) @ (target - plant.tip)
            size = float(np.hypot(change[0], change[1]))
            slack = float((least - plant.muscle_forces).max())
            if size <= STEP and abs(slack) <= SLACK:
                return setpoint, slope
            change *= min(1.0, 0.2 / max(size, 1e-300))
            setpoint += spread @ change - slack / self._kp
        raise ConvergenceError("the plan of the tip", size, STEP, ITERATIONS, "rad")

    def _tip_by_setpoint(self) -> Array:
        """Return the derivative of the resting tip by set-points, shape (3, 3)."""
        model, data = self.plant.model, self.plant.data
        J = np.zeros((3, model.nv))
        mujoco.mj_jacBody(model, data, J, None, model.body("tip").id)
        return J @ np.linalg.solve(self._solver.tangent(), self._kp * self.plant.muscle_jacobian.T)

    def moving_forces(self, q: Array, v: Array, a: Array) -> Array:
        """Return what a motion takes beside statics [N m]: minus inertia, minus joint damping; shape (dofs,)."""
        model, data = self.plant.model, self.plant.data
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        inertia, coriolis = np.zeros(model.nv), data.qfrc_bias.copy()
        mujoco.mj_mulM(model, data, inertia, data.qacc)
        data.qvel[:] = 0
        mujoco.mj_fwdVelocity(model, data)
        return -(inertia + coriolis - data.qfrc_bias + model.dof_damping * v)


@dataclass(frozen=True)
class _Planned:
    """Per sample: set-points and lengths [m], derivatives of the tip by the bend [m/rad], joint angles [rad]."""

    setpoint: Array
    lengths: Array
    slopes: Array
    q: Array

    def command(self) -> Command:
        inverse = np.asarray(np.linalg.pinv(self.slopes), dtype=float)
        return Command(self.lengths, self.setpoint, "tip", self.setpoint[0], inverse)


def plan_rest(arm: Arm, bend: Array, target: Array, ticks: Iterable[int] | None = None) -> Command:
    """Return the command that rests the tip as near to targets [m], shape (T, 3), as it gets; see `TipPlan`.

    Raises:
        ConvergenceError: names the pose that there is no such rest for.
    """
    return _solved(arm, bend, target, _guess(arm, bend), 0.0, ticks).command()


def plan_motion(arm: Arm, bend: Array, target: Array, period: float) -> Command:
    """Return the command that moves the tip along targets [m], shape (T, 3), one every `period` [s].

    Raises:
        ConvergenceError: as `plan_rest`.
    """
    from scipy.interpolate import CubicSpline

    time = period * np.arange(len(bend))
    every = max(1, round(1 / (RATE * period)))
    knots = np.unique(np.append(np.arange(0, len(bend), every), len(bend) - 1))
    if len(knots) < 4:
        return plan_rest(arm, bend, target)
    at, plan = time[knots], TipPlan(arm)
    found = _solved(arm, bend[knots], target[knots], _guess(arm, bend[knots]), 0.0)
    for _ in range(PASSES):
        path = CubicSpline(at, found.q)
        forces = [plan.moving_forces(*state) for state in zip(found.q, path(at, 1), path(at, 2), strict=True)]
        forces[0] *= 0.0  # the motion starts from rest
        speeds = CubicSpline(at, found.lengths)(at, 1)
        speeds[0] = 0.0
        least = least_tensions(speeds, arm.muscle.min_tension, arm)
        found = _solved(arm, bend[knots], target[knots], found, np.array(forces), least=least)
    parts = (found.setpoint, found.lengths, found.slopes, found.q)
    fine = _Planned(*(CubicSpline(at, part)(time) for part in parts))
    follow = fine.setpoint + arm.servo_time * np.gradient(fine.lengths, period, axis=0)
    return replace(fine.command(), setpoint=follow)


def _guess(arm: Arm, bend: Array) -> _Planned:
    """Return what the `servo` controller would do, without regard to where the tip is then."""
    plant, q = Plant(arm), []
    for one in bend:
        plant.reset(one)
        q.append(plant.data.qpos.copy())
    orders = command(arm, bend, "servo")
    return _Planned(orders.setpoint, orders.lengths, np.empty((len(bend), 3, 2)), np.array(q))


def _solved(
    arm: Arm,
    bend: Array,
    target: Array,
    guess: _Planned,
    forces: Array | float,
    ticks: Iterable[int] | None = None,
    least: Array | float | None = None,
) -> _Planned:
    """Solve every sample from a guess, under generalised forces [N m], shape (T, dofs), and least tensions, (T, 3)."""
    plan = TipPlan(arm)
    data = plan.plant.data
    setpoint, lengths, slopes, q = (np.empty_like(getattr(guess, item.name)) for item in fields(guess))
    forces = np.broadcast_to(forces, q.shape)
    least = np.broadcast_to(arm.muscle.min_tension if least is None else least, (len(bend), 3))
    with engine_room():
        for i in ticks if ticks is not None else range(len(bend)):
            data.qpos[:] = guess.q[i]
            try:
                setpoint[i], slopes[i] = plan.solve(bend[i], target[i], guess.setpoint[i], forces[i], least[i])
            except ConvergenceError as error:
                angle, plane = (float(np.degrees(x)) for x in arc.to_polar(bend[i]))
                raise error.located(f"at a bend of {angle:.0f} deg towards {plane:.0f} deg") from None
            lengths[i], q[i] = plan.plant.muscle_lengths, data.qpos
    return _Planned(setpoint, lengths, slopes, q)

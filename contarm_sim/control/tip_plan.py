"""Set-points that bring the model's own tip to its targets: statics and dynamics of the whole chain, inverted.

Three lengths steer two of the tip's three coordinates, so each sample is a small least-squares problem: the bend whose
muscle lengths let the tip, at rest under gravity and load, come nearest to its target. Gauss-Newton solves it, damped
where that leads away, with the derivative of the resting tip by lengths that the last step of `holding` has found. In
motion the same problem is solved again with what the planned joint angles take to move, inertia and damping, as forces
on the resting arm (d'Alembert).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace

import mujoco
import numpy as np

from contarm_sim.control.command import Command, command
from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.errors import ConvergenceError, NoRestError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.routing import length_jacobian, lengths_from_bend
from contarm_sim.mechanics.statics import least_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.statics.holding import Holder
from contarm_sim.statics.solver import Solver

STEP = 1e-7
"""Change of the bend at which a sample has converged [rad]."""

LONGEST = 0.2
"""Largest change of the bend at once [rad]."""

LARGEST = 0.98 * np.pi
"""Largest bend that is tried [rad]."""

ITERATIONS = 60
"""Most steps for one sample, those taken back included; a handful do."""

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
        self._holder = Holder(Solver(self.plant))

    def solve(
        self, bend: Array, target: Array, forces: Array | float = 0.0, least: Array | None = None, checked: bool = True
    ) -> tuple[Array, Array]:
        """Bring the tip from its current pose as near to a target [m], shape (3,), as it gets.

        Args:
            bend: about where that is [rad], shape (2,): what the plan falls back to.
            forces: generalised forces on the joints [N m], shape (dofs,).
            least: tensions that the muscles keep at least [N], shape (3,); default the arm's least.
            checked: refuse set-points that servos at rest cannot follow.

        Returns:
            the set-points [m], shape (3,), and the derivative of the tip by the bend asked for [m/rad], shape (3, 2).

        Raises:
            NoRestError: there is no pose at rest at this bend; says why.
        """
        holder, data = self._holder, self.plant.data
        holder.extra = forces
        holder.least = np.full(3, self.plant.arm.muscle.min_tension) if least is None else least
        holder.tensions = holder.least.copy()
        bend, damping = bend.copy(), 0.0
        holder(lengths_from_bend(bend, self.plant.arm))
        slope, off, curved = self._slope(bend), target - self.plant.tip, np.zeros((2, 2))
        excess = holder.excess()
        for _ in range(ITERATIONS):
            gram = slope.T @ slope + curved
            change = np.linalg.solve(gram + (damping + 1e-12) * np.trace(gram) * np.eye(2), slope.T @ off)
            size = float(np.hypot(*change))
            if size <= STEP:
                break
            change *= min(1.0, LONGEST / size)
            before = data.qpos.copy(), holder.tensions, slope
            if self._nearer(bend + change, target, float(off @ off), excess):
                bend, damping = bend + change, 0.2 * damping if damping > 1e-3 else 0.0
                slope, off, excess = self._slope(bend), target - self.plant.tip, holder.excess()
                curved = _curved(curved, change, (before[2] - slope).T @ off, slope)
            else:
                data.qpos[:], holder.tensions = before[:2]
                damping, curved = max(4 * damping, 1e-2), np.zeros((2, 2))
        holder(lengths_from_bend(bend, self.plant.arm))
        return holder.setpoints(checked), slope

    def _nearer(self, bend: Array, target: Array, square: float, excess: float) -> bool:
        """Whether the tip, at rest at a bend, is no farther from its target than before, and as well held."""
        if np.hypot(*bend) > LARGEST:
            return False
        try:
            self._holder(lengths_from_bend(bend, self.plant.arm))
        except NoRestError:
            return False
        off = target - self.plant.tip
        near = off @ off <= square + (1e-9 * self.plant.arm.length) ** 2
        return bool(near and self._holder.excess() <= excess)

    def _slope(self, bend: Array) -> Array:
        """Return the derivative of the resting tip by the bend whose lengths it has [m/rad], shape (3, 2)."""
        model, data = self.plant.model, self.plant.data
        J = np.zeros((3, model.nv))
        mujoco.mj_jacBody(model, data, J, None, model.body("tip").id)
        return J @ self._holder.by_lengths() @ length_jacobian(bend, self.plant.arm)

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


def _curved(curved: Array, change: Array, turned: Array, slope: Array) -> Array:
    """Return what the tip's second derivative adds to slope^T slope, shape (2, 2), from what one step has shown.

    Targets off the surface of resting tips make Gauss-Newton slow without it. Symmetric rank one; nothing where the sum
    would not be positive.
    """
    miss = turned - curved @ change
    along = float(miss @ change)
    if abs(along) > 1e-8 * float(np.linalg.norm(miss) * np.linalg.norm(change)):
        curved = curved + np.outer(miss, miss) / along
    total = slope.T @ slope + curved
    positive = total[0, 0] > 0 and total[0, 0] * total[1, 1] > 1.01 * total[0, 1] * total[1, 0]
    return curved if positive else np.zeros((2, 2))


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
    return planned_rest(arm, bend, target, ticks)[0]


def planned_rest(arm: Arm, bend: Array, target: Array, ticks: Iterable[int] | None = None) -> tuple[Command, Array]:
    """Return the command of `plan_rest` and the joint angles that it comes to rest in [rad], shape (T, dofs).

    Raises:
        ConvergenceError: as `plan_rest`.
    """
    found = _solved(arm, bend, target, _guess(arm, bend), 0.0, ticks)
    return found.command(), found.q


def plan_motion(arm: Arm, bend: Array, target: Array, period: float) -> Command:
    """Return the command that moves the tip along targets [m], shape (T, 3), one every `period` [s].

    Where the forces of the motion leave a pose without rest, as they do with arms that are very soft for their weight,
    the plan is that of poses at rest; where one of these has none either, set-points are those of `servo`, and only the
    tip's feedback is left.
    """
    from scipy.interpolate import CubicSpline

    time = period * np.arange(len(bend))
    every = max(1, round(1 / (RATE * period)))
    knots = np.unique(np.append(np.arange(0, len(bend), every), len(bend) - 1))
    if len(knots) < 4:
        return plan_rest(arm, bend, target)
    at, plan = time[knots], TipPlan(arm)
    try:
        found = _solved(arm, bend[knots], target[knots], _guess(arm, bend[knots]), 0.0, moving=True)
    except ConvergenceError:
        inverse = np.asarray(np.linalg.pinv(arc.jacobian(bend, arm.length)), dtype=float)
        return replace(command(arm, bend, "servo", period), controller="tip", tip_to_bend=inverse)
    for _ in range(PASSES):
        path = CubicSpline(at, found.q)
        forces = [plan.moving_forces(*state) for state in zip(found.q, path(at, 1), path(at, 2), strict=True)]
        forces[0] *= 0.0  # the motion starts from rest
        speeds = CubicSpline(at, found.lengths)(at, 1)
        speeds[0] = 0.0
        least = least_tensions(speeds, arm.muscle.min_tension, arm)
        try:
            found = _solved(arm, bend[knots], target[knots], found, np.array(forces), least=least, moving=True)
        except ConvergenceError:
            break
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
    moving: bool = False,
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
                setpoint[i], slopes[i] = plan.solve(bend[i], target[i], forces[i], least[i], checked=not moving)
            except ConvergenceError as error:
                angle, plane = (float(np.degrees(x)) for x in arc.to_polar(bend[i]))
                raise error.located(f"at a bend of {angle:.0f} deg towards {plane:.0f} deg") from None
            lengths[i], q[i] = plan.plant.muscle_lengths, data.qpos
    return _Planned(setpoint, lengths, slopes, q)

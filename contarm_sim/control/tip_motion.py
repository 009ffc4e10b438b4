"""The motion of the tip, planned: set-points for all samples of a reference, from poses solved one by one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contarm_sim.control.plan import Plan
from contarm_sim.control.servo import Servo
from contarm_sim.control.tip_plan import TipPlan
from contarm_sim.control.tip_plan_many import Asked, solve_many
from contarm_sim.engine.plant import Plant
from contarm_sim.engine.room import engine_room
from contarm_sim.errors import EquilibriumError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.muscles import each
from contarm_sim.mechanics.servos import least_tensions
from contarm_sim.mechanics.statics import min_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference

RATE = 25.0
"""Samples solved per second of motion [Hz]; splines between."""

WEAK = 0.05
"""Of the tip's derivatives, what share of their size counts as hardly any."""

PASSES = 2
"""Times that the moving arm's forces are found from the motion planned last."""


@dataclass(frozen=True)
class TipCommands(Plan):
    """A plan, and how the bend asked for moves the resting tip.

    Attributes:
        tip_to_bend: change of the bend [rad] by which the resting tip moves as asked for [m], shape (T, 2 S, 3).
    """

    tip_to_bend: Array


def inverted(slopes: Array) -> Array:
    """Return the least bends [rad/m], shape (..., 2 S, 3), that move the tip, of its derivatives, shape (..., 3, 2 S).

    Of several sections, ways that the tip hardly moves in are left: straight, it does not move along itself at all.
    """
    if slopes.shape[-1] == 2:
        return np.asarray(np.linalg.pinv(slopes), dtype=float)
    turned = slopes.swapaxes(-1, -2)
    gram = slopes @ turned
    left = (WEAK**2 * np.trace(gram, axis1=-2, axis2=-1))[..., None, None] * np.eye(3)
    return np.asarray(turned @ np.linalg.inv(gram + left))


@dataclass(frozen=True)
class _Planned:
    """Of one sample, or of all: set-points and lengths [m], the tip's derivatives by the bend [m/rad], joint angles."""

    setpoint: Array
    lengths: Array
    slopes: Array
    q: Array

    def commands(self) -> TipCommands:
        return TipCommands(self.lengths, self.setpoint, self.setpoint[0], inverted(self.slopes))


@dataclass(frozen=True)
class _Under:
    """What samples are solved under.

    Attributes:
        forces: generalised forces on the joints [N m], shape (T, dofs).
        least: least tensions [N], shape (T, n); None for the arm's.
        moving: whether servos may ask for more than they could hold at rest.
    """

    forces: Array | float = 0.0
    least: Array | None = None
    moving: bool = False


def plan_rest(arm: Arm, bend: Array, target: Array) -> TipCommands:
    """Return the commands that rest the tip as near to targets [m], shape (T, 3), as it gets; see `TipPlan`.

    Raises:
        EquilibriumError: names the pose that there is no such rest for.
    """
    return _solved(arm, bend, target, _guess(arm, bend), _Under()).commands()


def plan_motion(arm: Arm, reference: Reference) -> TipCommands:
    """Return the commands that move the tip along a reference's targets.

    Raises:
        EquilibriumError: names the pose that there is no rest for.
    """
    from scipy.interpolate import CubicSpline

    bend, target, period = reference.bend, reference.target, 1 / reference.rate
    time = period * np.arange(len(bend))
    every = max(1, round(1 / (RATE * period)))
    knots = np.unique(np.append(np.arange(0, len(bend), every), len(bend) - 1))
    if len(knots) < 4:
        return plan_rest(arm, bend, target)
    at = time[knots]
    found = _solved(arm, bend[knots], target[knots], _guess(arm, bend[knots]), _Under(moving=True))
    plant = Plant(arm)
    for _ in range(PASSES):
        path = CubicSpline(at, found.q)
        forces = np.array([-plant.inertial_forces(*q) for q in zip(found.q, path(at, 1), path(at, 2), strict=True)])
        forces[0] *= 0.0  # the motion starts from rest
        speeds = CubicSpline(at, found.lengths)(at, 1)
        speeds[0] = 0.0
        least = least_tensions(speeds, min_tensions(arm), arm)
        try:
            found = _solved(arm, bend[knots], target[knots], found, _Under(forces, least, moving=True))
        except EquilibriumError:
            break
    parts = (found.setpoint, found.lengths, found.slopes, found.q)
    fine = _Planned(*(CubicSpline(at, part)(time) for part in parts)).commands()
    follow = fine.setpoint + each(arm, lambda group: group.servo_time) * np.gradient(fine.lengths, period, axis=0)
    return TipCommands(fine.lengths, follow, fine.start, fine.tip_to_bend)


def _guess(arm: Arm, bend: Array) -> _Planned:
    """Return what the `servo` controller would do, without regard to where the tip is then."""
    plant, q = Plant(arm), []
    for one in bend:
        plant.reset(one)
        q.append(plant.data.qpos.copy())
    plan = Servo().plan(arm, Reference.from_bends(bend, arm))
    return _Planned(plan.setpoint, plan.lengths, np.empty((len(bend), 3, bend.shape[1])), np.array(q))


def planner(
    arm: Arm, bend: Array, target: Array, guess: _Planned | None = None, under: _Under | None = None
) -> Callable[[int], _Planned]:
    """Return a function that solves one sample, from a guess, by default what `servo` would do.

    Raises:
        EquilibriumError: from the function: there is no pose at rest at this bend; says why.
    """
    guess, under, plan = guess or _guess(arm, bend), under or _Under(), TipPlan(arm)
    data = plan.plant.data
    forces, least = _each(arm, guess, under)

    def solve(i: int) -> _Planned:
        data.qpos[:] = guess.q[i]
        setpoint, slopes = plan.solve(bend[i], target[i], forces[i], least[i], checked=not under.moving)
        return _Planned(setpoint, plan.plant.muscle_lengths, slopes, data.qpos.copy())

    return solve


def _solved(arm: Arm, bend: Array, target: Array, guess: _Planned, under: _Under) -> _Planned:
    forces, least = _each(arm, guess, under)
    with engine_room():
        found = solve_many(arm, Asked(guess.q, bend, target, forces, least, checked=not under.moving))
        if len(found) < len(bend):
            solve = planner(arm, bend, target, guess, under)
        for i in range(len(bend)):
            if i not in found:
                try:
                    one = solve(i)
                except EquilibriumError as error:
                    raise error.located(f"at {shape.described(bend[i], arm)}") from None
                found[i] = one.setpoint, one.lengths, one.slopes, one.q
    return _Planned(*(np.array(part) for part in zip(*(found[i] for i in range(len(bend))), strict=True)))


def _each(arm: Arm, guess: _Planned, under: _Under) -> tuple[Array, Array]:
    """Return forces on the joints [N m], shape (T, dofs), and least tensions [N], shape (T, n), of all samples."""
    least = min_tensions(arm) if under.least is None else under.least
    return np.broadcast_to(under.forces, guess.q.shape), np.broadcast_to(least, guess.lengths.shape)

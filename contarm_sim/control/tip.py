"""Servo, with lengths at which the model's own tip rests on its target, and the seen tip fed back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from contarm_sim.control.base import Feedback, Memory, Plan, Seen
from contarm_sim.control.servo import LengthFeedback, Servo
from contarm_sim.errors import EquilibriumError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.statics import least_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference

if TYPE_CHECKING:
    from contarm_sim.engine.plant import Plant

RATE = 25.0
"""Samples solved per second of motion [Hz]; splines between."""

PASSES = 2
"""Times that the moving arm's forces are found from the motion planned last."""


@dataclass(frozen=True)
class TipCommands(Plan):
    """A plan, and how the bend asked for moves the resting tip.

    Attributes:
        tip_to_bend: change of the bend [rad] by which the resting tip moves as asked for [m], shape (T, 2, 3).
    """

    tip_to_bend: Array


class Tip(Servo):
    """Brings the tip to its targets: inverts the full chain model, statics and dynamics, then adds tip feedback.

    Args:
        planned: plan with the chain model; False: with the arc's, as where a motion is not known in advance.
    """

    name = "tip"
    holds_lengths = False

    def __init__(self, planned: bool = True) -> None:
        self.planned = planned

    def plan(self, arm: Arm, reference: Reference) -> TipCommands:
        """Return lengths and set-points under which the model's tip follows its targets.

        Where the forces of the motion leave a pose without rest, as they do with arms that are very soft for their
        weight, the plan is that of poses at rest; where one of these has none either, set-points are those of `servo`,
        and only the tip's feedback is left.

        Raises:
            EquilibriumError: poses at rest, and one has none; names it.
        """
        if self.planned and not reference.moving:
            return plan_rest(arm, reference.bend, reference.target)
        if self.planned:
            try:
                return plan_motion(arm, reference)
            except EquilibriumError:
                pass
        plan = super().plan(arm, reference)
        inverse = np.asarray(np.linalg.pinv(arc.jacobian(reference.bend, arm.length)), dtype=float)
        return TipCommands(plan.lengths, plan.setpoint, plan.start, inverse)

    def feedback(self, arm: Arm, reference: Reference, plan: Plan) -> Feedback:
        """Return the integrals of tip and length errors."""
        assert isinstance(plan, TipCommands)
        return TipFeedback(arm, plan, reference)

    def resting(self, plant: Plant, reference: Reference) -> Callable[[int], Array]:
        """Return what brings the tip as near to its target at rest as it gets."""
        from contarm_sim.statics.solver import Solver

        arm, settle = plant.arm, Solver(plant)
        solve = _solver(arm, reference.bend, reference.target, _guess(arm, reference.bend))

        def rest(index: int) -> Array:
            setpoint, _, _, plant.data.qpos[:] = solve(index)
            settle(setpoint)
            return setpoint

        return rest


class TipFeedback(Feedback):
    """Shifts lengths so that the seen tip approaches its target, on top of `LengthFeedback`.

    The tip has three coordinates, the section two degrees of freedom: an error along the reachable surface is removed,
    one across it is not in any controller's power (a sagging arm's tips form another surface than the dome).
    """

    def __init__(self, arm: Arm, plan: TipCommands, reference: Reference) -> None:
        self._target, self._to_bend = reference.target, plan.tip_to_bend
        self._spread = length_jacobian(reference.bend, arm)
        self._lengths = LengthFeedback(arm, plan.lengths)
        self.time = max(0.2, 2 * self._lengths.time)  # half of it shakes an upright arm with 100 g
        self._offset, self.value = np.zeros(2), np.zeros_like(self._lengths.value)

    @property
    def memory(self) -> Memory:
        """What has been summed up."""
        return self._offset.copy(), *self._lengths.memory

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self._offset[:], *lengths = memory
        self._lengths.memory = tuple(lengths)
        np.add(self._lengths.value, self._lengths.shift, out=self.value)

    def update(self, index: int, seen: Seen, gain: float) -> None:
        """Integrate one interval of sample `index`."""
        self._lengths.update(index, seen, gain * self.time / self._lengths.time)
        self._offset += gain * (self._to_bend[index] @ (self._target[index] - seen.tip))
        self._lengths.shift[:] = self._spread[index] @ self._offset
        np.add(self._lengths.value, self._lengths.shift, out=self.value)


@dataclass(frozen=True)
class _Planned:
    """Per sample: set-points and lengths [m], derivatives of the tip by the bend [m/rad], joint angles [rad]."""

    setpoint: Array
    lengths: Array
    slopes: Array
    q: Array

    def commands(self) -> TipCommands:
        inverse = np.asarray(np.linalg.pinv(self.slopes), dtype=float)
        return TipCommands(self.lengths, self.setpoint, self.setpoint[0], inverse)


def plan_rest(arm: Arm, bend: Array, target: Array) -> TipCommands:
    """Return the commands that rest the tip as near to targets [m], shape (T, 3), as it gets; see `TipPlan`.

    Raises:
        EquilibriumError: names the pose that there is no such rest for.
    """
    return _solved(arm, bend, target, _guess(arm, bend)).commands()


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
    found = _solved(arm, bend[knots], target[knots], _guess(arm, bend[knots]), moving=True)
    plant = _plant(arm)
    for _ in range(PASSES):
        path = CubicSpline(at, found.q)
        forces = np.array([-plant.inertial_forces(*q) for q in zip(found.q, path(at, 1), path(at, 2), strict=True)])
        forces[0] *= 0.0  # the motion starts from rest
        speeds = CubicSpline(at, found.lengths)(at, 1)
        speeds[0] = 0.0
        least = least_tensions(speeds, arm.muscle.min_tension, arm)
        try:
            found = _solved(arm, bend[knots], target[knots], found, forces, least, moving=True)
        except EquilibriumError:
            break
    parts = (found.setpoint, found.lengths, found.slopes, found.q)
    fine = _Planned(*(CubicSpline(at, part)(time) for part in parts)).commands()
    follow = fine.setpoint + arm.servo_time * np.gradient(fine.lengths, period, axis=0)
    return TipCommands(fine.lengths, follow, fine.start, fine.tip_to_bend)


def _plant(arm: Arm) -> Plant:
    from contarm_sim.engine.plant import Plant

    return Plant(arm)


def _guess(arm: Arm, bend: Array) -> _Planned:
    """Return what the `servo` controller would do, without regard to where the tip is then."""
    plant, q = _plant(arm), []
    for one in bend:
        plant.reset(one)
        q.append(plant.data.qpos.copy())
    plan = Servo().plan(arm, Reference.from_bends(bend, arm))
    return _Planned(plan.setpoint, plan.lengths, np.empty((len(bend), 3, 2)), np.array(q))


Solved = tuple[Array, Array, Array, Array]


def _solver(
    arm: Arm,
    bend: Array,
    target: Array,
    guess: _Planned,
    forces: Array | float = 0.0,
    least: Array | float | None = None,
    moving: bool = False,
) -> Callable[[int], Solved]:
    """Return a function that solves a sample from a guess, and returns what `_Planned` holds of it."""
    from contarm_sim.control.tip_plan import TipPlan

    plan = TipPlan(arm)
    data = plan.plant.data
    every = np.broadcast_to(forces, guess.q.shape)
    tensions = np.broadcast_to(arm.muscle.min_tension if least is None else least, guess.lengths.shape)

    def solve(i: int) -> Solved:
        data.qpos[:] = guess.q[i]
        setpoint, slopes = plan.solve(bend[i], target[i], every[i], tensions[i], checked=not moving)
        return setpoint, plan.plant.muscle_lengths, slopes, data.qpos.copy()

    return solve


def _solved(
    arm: Arm,
    bend: Array,
    target: Array,
    guess: _Planned,
    forces: Array | float = 0.0,
    least: Array | float | None = None,
    moving: bool = False,
) -> _Planned:
    """Solve every sample from a guess, under generalised forces [N m], shape (T, dofs), and least tensions, (T, n)."""
    from contarm_sim.engine.room import engine_room

    solve = _solver(arm, bend, target, guess, forces, least, moving)
    found = []
    with engine_room():
        for i in range(len(bend)):
            try:
                found.append(solve(i))
            except EquilibriumError as error:
                raise error.located(f"at {arc.described(bend[i])}") from None
    return _Planned(*(np.array(part) for part in zip(*found, strict=True)))

"""Feed-forward, and an integral: on what lengths differ by, and on the slackest muscle's tension."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from contarm_sim.control.feedback import Feedback, Memory, Seen, by_tick
from contarm_sim.control.feedforward import Feedforward
from contarm_sim.control.plan import Plan
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import slices
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.servos import SERVO_SHARE, servo_tensions
from contarm_sim.mechanics.statics import cocontraction
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference

if TYPE_CHECKING:
    from contarm_sim.control.base import Samples
    from contarm_sim.engine.plant import Plant
    from contarm_sim.statics.rested import Rested


class Servo(Feedforward):
    """Holds muscle lengths to rounding: `Feedforward` with `LengthFeedback`."""

    name = "servo"

    def feedback(self, arm: Arm, reference: Reference, plan: Plan) -> Feedback:
        """Return the integral of length errors."""
        return LengthFeedback(arm, plan.lengths)

    def resting(self, plant: Plant, reference: Reference) -> Callable[[int], Array]:
        """Return what holds the lengths at rest: the pose that the integral ends in, found at once."""
        from contarm_sim.statics.holding import Holder
        from contarm_sim.statics.solver import Solver

        holder, plan = Holder(Solver(plant)), self.plan(plant.arm, reference)

        def rest(index: int) -> Array:
            lengths = plan.lengths[index]
            holder.tensions = servo_tensions(plan.setpoint[index], lengths, plant.arm)
            holder(lengths)
            plant.control[:] = setpoint = holder.setpoints()
            holder.check()
            return setpoint

        return rest

    def resting_together(self, plant: Plant, reference: Reference) -> Callable[[Samples], Rested] | None:
        """Return what holds the lengths of many samples at rest at once."""
        from contarm_sim.statics.rested import held

        plan = self.plan(plant.arm, reference)

        def rest(samples: Samples) -> Rested:
            lengths = plan.lengths[samples]
            tensions = servo_tensions(plan.setpoint[samples], lengths, plant.arm)
            return held(plant, reference.bend[samples], lengths, tensions)

        return rest


class LengthFeedback(Feedback):
    """Integrates errors of length [m].

    Only what a bend changes of the lengths is integrated: the rest does not move an inextensible backbone, it only
    makes the muscles fight. Co-contraction instead keeps the slackest muscle of each section at its least tension, and
    every servo pulling. While a servo is at a limit, where more of it does nothing, errors are not integrated.

    Attributes:
        shift: what is added to the lengths wanted [m], shape (n,); another feedback may change it.
    """

    def __init__(self, arm: Arm, wanted: Array) -> None:
        # Slow beside the servo: ten times what its integral would swing up at; fast beside a path.
        slowest = max(10 / (max(group.servo_time, 1e-3) * group.servo_frequency**2) for group in arm.groups)
        super().__init__(max(0.1, slowest), wanted.shape[1])
        self._wanted = wanted.tolist()
        straight = np.zeros(2 * len(arm.sections))
        J, common = length_jacobian(straight, arm), cocontraction(straight, arm)
        # Orthonormal directions of lengths that no bend changes: for three muscles, what they have in common.
        self._fights: list[list[float]] = np.linalg.svd(J)[0][:, J.shape[1] :].T.tolist()
        self._groups = [
            (own.start, own.stop, group.law.min_tension, group.law.blocked_force, 1 / group.servo_stiffness,
             [(i, pull) for i, pull in enumerate(common[number].tolist()) if pull])
            for number, (group, own) in enumerate(zip(arm.groups, slices(arm), strict=True))
        ]  # fmt: skip
        self._each = range(len(J))
        self.shift = np.zeros(len(J))
        shift: Any = memoryview(self.shift)  # type: ignore[arg-type]
        value: Any = memoryview(self.value)  # type: ignore[arg-type]
        self._shift, self._value = shift, value
        self._numbers: type[_Floats] | type[_Arrays] = _Floats

    @classmethod
    def together(cls, each: Sequence[LengthFeedback], ticks: Sequence[slice]) -> LengthFeedback:
        """Return one of many arms."""
        many: Any = copy.copy(each[0])
        many.time, many._numbers = np.array([one.time for one in each]), _Arrays
        many._wanted = np.ascontiguousarray(by_tick([one._wanted for one in each], ticks).swapaxes(1, 2))
        many._fights = np.moveaxis(np.array([one._fights for one in each]), 0, -1)
        many._groups = [_group_of_many(same) for same in zip(*(one._groups for one in each), strict=True)]
        many._shift, many._value = (np.array([getattr(one, x) for one in each]).T.copy() for x in ("shift", "value"))
        many.shift, many.value = many._shift.T, many._value.T
        return cast("LengthFeedback", many)

    @property
    def memory(self) -> Memory:
        """What has been summed up."""
        return self.shift.copy(), self.value.copy()

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self.shift[:], self.value[:] = memory

    def update(self, index: int, seen: Seen, gain: float) -> None:
        """Integrate one interval of sample `index`."""
        # Plain floats and plain loops: this runs every tick, where an array operation on three numbers, or a list
        # comprehension, costs as much as ten operations on floats. Of many arms, every number is an array of theirs.
        each, wanted, shift, lengths, value = self._each, self._wanted[index], self._shift, seen.lengths, self._value
        numbers, error = self._numbers, []
        least_of, most_of = numbers.least, numbers.most
        for i in each:
            error.append(wanted[i] + shift[i] - lengths[i])
        for fight in self._fights:
            along = 0.0
            for i in each:
                along += fight[i] * error[i]
            for i in each:
                error[i] -= along * fight[i]
        free, pulls, tensions, loosened = gain, seen.pulls, seen.tensions, [0.0] * len(error)
        for first, end, least, blocked, per_newton, direction in self._groups:
            pulled = pulls[first:end]
            weakest = least_of(pulled)
            free = numbers.unless_limited(free, weakest, most_of(pulled), blocked)
            slack = numbers.larger(least - least_of(tensions[first:end]), SERVO_SHARE * least - weakest)
            common = gain * slack * per_newton
            for i, pull in direction:
                loosened[i] += common * pull
        for i in each:
            value[i] += free * error[i] - loosened[i]


class _Floats:
    """What `LengthFeedback` needs of the numbers of one arm."""

    least, most, larger = min, max, max

    @staticmethod
    def unless_limited(free: Any, weakest: Any, strongest: Any, blocked: Any) -> Any:
        """Return a gain, or 0 where a servo is at a limit."""
        return 0.0 if weakest <= 0 or strongest >= blocked else free


class _Arrays:
    """The same of many arms."""

    larger = np.maximum

    @staticmethod
    def least(rows: Any) -> Any:
        """Return the least of all rows, arm by arm."""
        return rows.min(axis=0)

    @staticmethod
    def most(rows: Any) -> Any:
        """Return the largest of all rows, arm by arm."""
        return rows.max(axis=0)

    @staticmethod
    def unless_limited(free: Any, weakest: Any, strongest: Any, blocked: Any) -> Any:
        """Return gains, or 0 where a servo is at a limit."""
        return np.where((weakest <= 0) | (strongest >= blocked), 0.0, free)


def _group_of_many(same: Sequence[Any]) -> tuple[Any, ...]:
    """Return what `LengthFeedback` keeps of a group of muscles, numbers becoming arrays over arms."""
    first, end, *_ = same[0]
    least, blocked, per_newton = (np.array([group[number] for group in same]) for number in (2, 3, 4))
    pulls: dict[int, Array] = {}
    for arm, group in enumerate(same):
        for i, pull in group[5]:
            pulls.setdefault(i, np.zeros(len(same)))[arm] = pull
    return first, end, least, blocked, per_newton, sorted(pulls.items())

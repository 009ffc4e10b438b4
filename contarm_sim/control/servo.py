"""Feed-forward, and an integral: on what lengths differ by, and on the slackest muscle's tension."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from contarm_sim.control.feedback import Feedback, Memory, Seen
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
    from contarm_sim.control.base import Places
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

    def resting_together(self, plant: Plant, reference: Reference) -> Callable[[Places], Rested] | None:
        """Return what holds the lengths of many samples at rest at once."""
        from contarm_sim.statics.rested import held

        plan = self.plan(plant.arm, reference)

        def rest(samples: Places) -> Rested:
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
        # comprehension, costs as much as ten operations on floats.
        each, wanted, shift, lengths, value = self._each, self._wanted[index], self._shift, seen.lengths, self._value
        error = []
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
            weakest = min(pulled)
            if weakest <= 0 or max(pulled) >= blocked:
                free = 0.0
            slack = max(least - min(tensions[first:end]), SERVO_SHARE * least - weakest)
            common = gain * slack * per_newton
            for i, pull in direction:
                loosened[i] += common * pull
        for i in each:
            value[i] += free * error[i] - loosened[i]

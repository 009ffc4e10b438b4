"""Servo, with lengths at which the model's own tip rests on its target, and the seen tip fed back."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from contarm_sim.control.feedback import Feedback, Memory, Seen, applied, by_tick
from contarm_sim.control.plan import Plan
from contarm_sim.control.servo import LengthFeedback, Servo
from contarm_sim.control.tip_motion import TipCommands, inverted, plan_motion, plan_rest, planner
from contarm_sim.errors import EquilibriumError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference

if TYPE_CHECKING:
    from contarm_sim.engine.plant import Plant


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
        inverse = inverted(shape.tip_jacobian(reference.bend, arm))
        return TipCommands(plan.lengths, plan.setpoint, plan.start, inverse)

    def unplanned(self) -> Tip:
        """Return the controller that plans with the arc's tip."""
        return Tip(planned=False)

    def feedback(self, arm: Arm, reference: Reference, plan: Plan) -> Feedback:
        """Return the integrals of tip and length errors."""
        assert isinstance(plan, TipCommands)
        return TipFeedback(arm, plan, reference)

    def resting(self, plant: Plant, reference: Reference) -> Callable[[int], Array]:
        """Return what brings the tip as near to its target at rest as it gets."""
        from contarm_sim.statics.solver import Solver

        arm, settle = plant.arm, Solver(plant)
        solve = planner(arm, reference.bend, reference.target)

        def rest(index: int) -> Array:
            found = solve(index)
            plant.data.qpos[:] = found.q
            settle(found.setpoint)
            return found.setpoint

        return rest


class TipFeedback(Feedback):
    """Shifts lengths so that the seen tip approaches its target, on top of `LengthFeedback`.

    The tip has three coordinates, one section two degrees of freedom: an error along the reachable surface is removed,
    one across it is not in any controller's power (a sagging arm's tips form another surface than the dome). Several
    sections move the tip every way, by the least change of their bends.
    """

    def __init__(self, arm: Arm, plan: TipCommands, reference: Reference) -> None:
        self._target, self._to_bend = reference.target, plan.tip_to_bend
        self._spread = length_jacobian(reference.bend, arm)
        self._lengths = LengthFeedback(arm, plan.lengths)
        # Half of this time shakes an upright arm with 100 g.
        super().__init__(max(0.2, 2 * self._lengths.time), plan.start.size)
        self._offset = np.zeros(self._spread.shape[-1])

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
        off = applied(self._to_bend[index], self._target[index] - seen.tip)
        self._offset += np.asarray(gain)[..., None] * off
        self._lengths.shift[:] = applied(self._spread[index], self._offset)
        np.add(self._lengths.value, self._lengths.shift, out=self.value)

    @classmethod
    def together(cls, each: Sequence[TipFeedback], ticks: Sequence[slice]) -> TipFeedback:
        """Return one of many arms."""
        many: Any = copy.copy(each[0])
        many.time = np.array([one.time for one in each])
        many._lengths = LengthFeedback.together([one._lengths for one in each], ticks)
        for name in ("_target", "_to_bend", "_spread"):
            setattr(many, name, by_tick([getattr(one, name) for one in each], ticks))
        for name in ("_offset", "value"):
            setattr(many, name, np.array([getattr(one, name) for one in each]))
        return cast("TipFeedback", many)

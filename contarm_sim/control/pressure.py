"""The servo's work done by McKibben muscles behind valves: tensions become pressures, the valves' lag is led."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from contarm_sim.control.base import Controller
from contarm_sim.control.feedback import Feedback, Memory, Seen, applied, by_tick
from contarm_sim.control.plan import Plan
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import pneumatics, routing
from contarm_sim.mechanics.muscles import each
from contarm_sim.mechanics.pressures import holding_pressures
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.statics import balance, min_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference

if TYPE_CHECKING:
    from contarm_sim.control.base import Samples
    from contarm_sim.engine.plant import Plant
    from contarm_sim.statics.rested import Rested


class Pressure(Controller):
    """Pressures that hold the bend, and an integral on the measured bend."""

    name = "pressure"
    actuation = "pressures"

    def limits(self, arm: Arm) -> tuple[Array, Array]:
        """Return the lowest and the highest pressure of each muscle [Pa], shape (n,)."""
        return _lowest(arm), each(arm, lambda group: group.pneumatics.max_pressure)

    def plan(self, arm: Arm, reference: Reference) -> Plan:
        """Return lengths and pressures; in motion these lead the valves, and carry the backbone's damping."""
        bend = reference.bend
        lengths = routing.lengths_from_bend(bend, arm)
        if not reference.moving:
            held = holding_pressures(bend, arm)
            return Plan(lengths, held, held[0])
        period = 1 / reference.rate
        setpoint = holding_pressures(bend, arm, rate=np.gradient(bend, period, axis=0))
        lag = each(arm, lambda group: group.pneumatics.valve_time)
        setpoint = setpoint + lag * np.gradient(setpoint, period, axis=0)
        return Plan(lengths, setpoint, holding_pressures(bend[:1], arm)[0])

    def feedback(self, arm: Arm, reference: Reference, plan: Plan) -> Feedback:
        """Return the integral of the bend's error."""
        return PressureFeedback(arm, plan, reference.bend)

    def resting(self, plant: Plant, reference: Reference) -> Callable[[int], Array]:
        """Return what holds the bend at rest: the pose that the integral ends in, found at once."""
        from contarm_sim.statics.holding import Holder
        from contarm_sim.statics.solver import Solver

        arm, holder, plan = plant.arm, Holder(Solver(plant)), self.plan(plant.arm, reference)

        def rest(index: int) -> Array:
            lengths = plan.lengths[index]
            per_pascal = pneumatics.force(1.0, lengths, arm)
            holder.least_pressures = np.maximum(_lowest(arm), min_tensions(arm) / per_pascal)
            holder.tensions = plan.setpoint[index] * per_pascal
            holder(lengths, np.linalg.qr(length_jacobian(reference.bend[index], arm))[0].T)
            plant.pressure[:] = plant.control[:] = setpoint = holder.pressures()
            holder.check()
            return setpoint

        return rest

    def resting_together(self, plant: Plant, reference: Reference) -> Callable[[Samples], Rested] | None:
        """Return what holds the bends of many samples at rest at once."""
        from contarm_sim.statics.rested import held

        arm, plan = plant.arm, self.plan(plant.arm, reference)

        def rest(samples: Samples) -> Rested:
            lengths, bend = plan.lengths[samples], reference.bend[samples]
            per_pascal = pneumatics.force(1.0, lengths, arm)
            least = np.maximum(_lowest(arm), min_tensions(arm) / per_pascal)
            meant = np.linalg.qr(length_jacobian(bend, arm))[0]
            return held(plant, bend, lengths, plan.setpoint[samples] * per_pascal, meant, least)

        return rest


class PressureFeedback(Feedback):
    """Integrates the error of the measured bend into pressures [Pa], keeping them within the limits.

    The moment that a bend is short of takes tensions, and these pressures, all through the closed forms of the
    commanded bend. Co-contraction stays the least that keeps every muscle at its lowest pressure and tension.
    """

    def __init__(self, arm: Arm, plan: Plan, bend: Array) -> None:
        # Half of this time lets a hanging arm with 100 g swing up by itself.
        super().__init__(max(0.4, 3 / arm.bend_frequency), plan.start.size)
        held = balance(bend, arm)
        J = length_jacobian(bend, arm)
        gram = J.swapaxes(-1, -2) @ J
        inverse = np.linalg.solve(gram, J.swapaxes(-1, -2))  # lengths to bend, and moments to tensions
        slopes = pneumatics.force_slope(plan.setpoint, plan.lengths, arm)
        springs = np.einsum("...im,...i,...in->...mn", J, slopes, J)
        own = [section.bending_stiffness / section.length for section in arm.sections]
        stiffness = np.diag(np.repeat(own, 2)) + springs
        self._wanted, self._base = plan.lengths, plan.setpoint
        self._to_bend = inverse
        self._by_bend = -(inverse.swapaxes(-1, -2) @ stiffness) / held.per_pascal[..., None]
        self._by_level = held.cocontraction / held.per_pascal[..., None, :]
        self._least = np.maximum(_lowest(arm), min_tensions(arm) / held.per_pascal)
        self._highest = each(arm, lambda group: group.pneumatics.max_pressure)
        self._offset = np.zeros(J.shape[-1])
        self._own = held.own

    @property
    def memory(self) -> Memory:
        """What has been summed up."""
        return self._offset.copy(), self.value.copy()

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self._offset[:], self.value[:] = memory

    def update(self, index: int, seen: Seen, gain: float) -> None:
        """Integrate one interval of sample `index`."""
        off = self._wanted[index] - np.asarray(seen.lengths).T
        self._offset += np.asarray(gain)[..., None] * applied(self._to_bend[index], off)
        base, by_level = self._base[index], self._by_level[index]
        asked, least = base + applied(self._by_bend[index], self._offset), self._least[index]
        for number in range(len(self._own))[::-1]:  # from the tip: see Balance
            own, direction = self._own[number], by_level[..., number, :]
            level = ((least[..., own] - asked[..., own]) / direction[..., own]).max(axis=-1)
            asked = asked + level[..., None] * direction
        self.value[:] = np.minimum(asked, self._highest) - base

    @classmethod
    def together(cls, each: Sequence[PressureFeedback], ticks: Sequence[slice]) -> PressureFeedback:
        """Return one of many arms."""
        many: Any = copy.copy(each[0])
        many.time = np.array([one.time for one in each])
        for name in ("_wanted", "_base", "_to_bend", "_by_bend", "_by_level", "_least"):
            setattr(many, name, by_tick([getattr(one, name) for one in each], ticks))
        for name in ("_highest", "_offset", "value"):
            setattr(many, name, np.array([getattr(one, name) for one in each]))
        return cast("PressureFeedback", many)


def _lowest(arm: Arm) -> Array:
    return each(arm, lambda group: group.pneumatics.min_pressure)

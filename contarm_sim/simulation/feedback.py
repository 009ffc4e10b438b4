"""Slow corrections of set-points: what a controller does about what it sees.

A feedback's `value` is added to the command's set-points. In motion it is updated once a control tick with the gain
tick / `time`; at rest with gain 1 until the error that `update` returns, in units of its tolerance, is at most 1.
`carry_on` takes over the corrections of another of its kind, made for other samples or another arm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import pneumatics
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.statics import SERVO_SHARE, balance
from contarm_sim.simulation.control import Command


@dataclass(frozen=True)
class Seen:
    """What a feedback sees, each of shape (3,): muscle lengths [m], tensions [N], what servos pull with [N], tip [m].

    Tensions are those of servos and damping along the muscles; pulling > 0.
    """

    lengths: Array
    tensions: Array
    pulls: Array
    tip: Array


class LengthFeedback:
    """Integrates errors of length [m].

    Only length *differences* are integrated: the common mode of three lengths does not move an inextensible
    backbone, it only makes the muscles fight. The common mode instead keeps the slackest muscle at
    its least tension, and every servo pulling. While a servo is at a limit, where more of it does nothing, differences
    are not integrated.
    """

    time = 0.1
    """Time constant [s]: slow beside the servo (0.02 s), fast beside a path."""

    def __init__(self, arm: Arm, wanted: Array) -> None:
        self._wanted = wanted
        self._least, self._blocked = arm.muscle.min_tension, arm.muscle.blocked_force
        self._per_newton = 1 / arm.servo_stiffness
        self.restart()

    def restart(self) -> None:
        """Forget all corrections."""
        self.shift = np.zeros(3)
        self.value = np.zeros(3)

    def carry_on(self, before: LengthFeedback) -> None:
        """Start from the corrections of another."""
        self.shift, self.value = before.shift.copy(), before.value.copy()

    def update(self, index: int, seen: Seen, gain: float) -> float:
        """Integrate one interval of sample `index`; return the error: 1 is 1 nm of length difference, 1 mN of slack."""
        # Plain floats: this runs every tick, where three numbers are not worth an array operation.
        w, m, s = self._wanted[index].tolist(), seen.lengths.tolist(), self.shift.tolist()
        errors = [w[0] + s[0] - m[0], w[1] + s[1] - m[1], w[2] + s[2] - m[2]]
        pulls = seen.pulls.tolist()
        mean, weakest = sum(errors) / 3, min(pulls)
        slack = max(self._least - min(seen.tensions.tolist()), SERVO_SHARE * self._least - weakest)
        common = slack * self._per_newton
        free = gain if weakest > 0 and max(pulls) < self._blocked else 0.0
        for i in (0, 1, 2):
            self.value[i] += free * (errors[i] - mean) - gain * common
        return max(abs(errors[0] - mean), abs(errors[1] - mean), abs(errors[2] - mean), 1e-6 * abs(slack)) / 1e-9


class TipFeedback:
    """Shifts lengths so that the seen tip approaches its target, on top of `LengthFeedback`.

    The tip has three coordinates, the section two degrees of freedom: an error along the reachable surface is removed,
    one across it is not in any controller's power (a sagging arm's tips form another surface than the dome).
    """

    time = 0.2
    """Time constant [s]; twice what still holds an upright arm with 100 g, which 0.1 s does not."""

    def __init__(self, arm: Arm, command: Command, bend: Array, target: Array) -> None:
        assert command.tip_to_bend is not None
        self._target, self._to_bend = target, command.tip_to_bend
        self._spread = length_jacobian(bend, arm)
        self._lengths = LengthFeedback(arm, command.lengths)
        self.restart()

    def restart(self) -> None:
        """Forget all corrections."""
        self._offset = np.zeros(2)
        self._lengths.restart()

    def carry_on(self, before: TipFeedback) -> None:
        """Start from the corrections of another."""
        self._offset = before._offset.copy()
        self._lengths.carry_on(before._lengths)

    @property
    def value(self) -> Array:
        """What to add to the set-points [m], shape (3,)."""
        return self._lengths.value + self._lengths.shift

    def update(self, index: int, seen: Seen, gain: float) -> float:
        """Integrate one interval of sample `index`; return the error of lengths as `LengthFeedback` does."""
        error = self._lengths.update(index, seen, gain * self.time / self._lengths.time)
        self._offset += gain * (self._to_bend[index] @ (self._target[index] - seen.tip))
        self._lengths.shift = self._spread[index] @ self._offset
        return error


class PressureFeedback:
    """Integrates the error of the measured bend into pressures [Pa], keeping them within the limits.

    The moment that a bend is short of takes tensions, and these pressures, all through the closed forms of the
    commanded bend. Co-contraction stays the least that keeps every muscle at its lowest pressure and tension.
    """

    time = 0.4
    """Time constant [s]; twice what lets an arm that hangs with 100 g swing up by itself."""

    def __init__(self, arm: Arm, command: Command, bend: Array) -> None:
        held = balance(bend, arm)
        J = length_jacobian(bend, arm)
        gram = J.swapaxes(-1, -2) @ J
        inverse = np.linalg.solve(gram, J.swapaxes(-1, -2))  # lengths to bend, and moments to tensions
        slopes = pneumatics.force_slope(command.setpoint, command.lengths, arm)
        springs = np.einsum("...im,...i,...in->...mn", J, slopes, J)
        stiffness = arm.bending_stiffness / arm.length * np.eye(2) + springs
        self._wanted, self._base = command.lengths, command.setpoint
        self._to_bend = inverse
        self._by_bend = -(inverse.swapaxes(-1, -2) @ stiffness) / held.per_pascal[..., None]
        self._by_level = held.cocontraction / held.per_pascal
        self._least = np.maximum(arm.muscle.min_pressure, arm.muscle.min_tension / held.per_pascal)
        self._highest = arm.muscle.max_pressure
        self.restart()

    def restart(self) -> None:
        """Forget all corrections."""
        self._offset = np.zeros(2)
        self.value = np.zeros(3)

    def carry_on(self, before: PressureFeedback) -> None:
        """Start from the corrections of another."""
        self._offset, self.value = before._offset.copy(), before.value.copy()

    def update(self, index: int, seen: Seen, gain: float) -> float:
        """Integrate one interval of sample `index`; return the error: 1 is 0.1 microradian of bend."""
        error = self._to_bend[index] @ (self._wanted[index] - seen.lengths)
        self._offset += gain * error
        base, by_level = self._base[index], self._by_level[index]
        asked = base + self._by_bend[index] @ self._offset
        level = max(((self._least[index] - asked) / by_level).tolist())
        self.value = np.minimum(asked + level * by_level, self._highest) - base
        return float(np.hypot(error[0], error[1])) / 1e-7


Feedback = LengthFeedback | TipFeedback | PressureFeedback


def feedback_for(arm: Arm, command: Command, bend: Array, target: Array) -> Feedback | None:
    """Return the feedback of a command's controller, or None if it has none."""
    if command.controller == "servo":
        return LengthFeedback(arm, command.lengths)
    if command.controller == "tip":
        return TipFeedback(arm, command, bend, target)
    if command.controller == "pressure":
        return PressureFeedback(arm, command, bend)
    return None

"""Slow corrections of set-points: what a controller does about what it sees.

A feedback's `value` is added to the command's set-points, and updated once a control tick with the gain tick / `time`,
a time constant [s]. `memory` is what it has summed up; another of its kind, made for other samples or another arm, may
take it over.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.control.command import Command
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import pneumatics
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.statics import SERVO_SHARE, balance
from contarm_sim.model.arm import Arm

Vector3 = Array | tuple[float, float, float]

Memory = tuple[Array, ...] | None
"""What a feedback has summed up so far; assigned to another of its kind, that goes on from there."""


@dataclass(slots=True)
class Seen:
    """What a feedback sees, each of shape (3,): muscle lengths [m], tensions [N], what servos pull with [N], tip [m].

    Tensions are those of servos and damping along the muscles; pulling > 0.
    """

    lengths: Vector3
    tensions: Vector3
    pulls: Vector3
    tip: Array


class LengthFeedback:
    """Integrates errors of length [m].

    Only length *differences* are integrated: the common mode of three lengths does not move an inextensible
    backbone, it only makes the muscles fight. The common mode instead keeps the slackest muscle at
    its least tension, and every servo pulling. While a servo is at a limit, where more of it does nothing, differences
    are not integrated.
    """

    def __init__(self, arm: Arm, wanted: Array) -> None:
        # Slow beside the servo: ten times what its integral would swing up at; fast beside a path.
        self.time = max(0.1, 10 / (max(arm.servo_time, 1e-3) * arm.servo_frequency**2))
        self._wanted = wanted.tolist()
        self._least, self._blocked = arm.muscle.min_tension, arm.muscle.blocked_force
        self._per_newton = 1 / arm.servo_stiffness
        self.shift, self.value = np.zeros(3), np.zeros(3)
        self._shift, self._value = memoryview(self.shift), memoryview(self.value)  # type: ignore[arg-type]

    @property
    def memory(self) -> Memory:
        """What has been summed up."""
        return self.shift.copy(), self.value.copy()

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self.shift[:], self.value[:] = memory or (0.0, 0.0)

    def update(self, index: int, seen: Seen, gain: float) -> None:
        """Integrate one interval of sample `index`."""
        # Plain floats: this runs every tick, where an array operation on three numbers costs as much as ten on floats.
        w1, w2, w3 = self._wanted[index]
        m1, m2, m3 = seen.lengths
        s1, s2, s3 = self._shift
        e1, e2, e3 = w1 + s1 - m1, w2 + s2 - m2, w3 + s3 - m3
        mean, weakest = (e1 + e2 + e3) / 3, min(seen.pulls)
        slack = max(self._least - min(seen.tensions), SERVO_SHARE * self._least - weakest)
        common = gain * slack * self._per_newton
        free = gain if weakest > 0 and max(seen.pulls) < self._blocked else 0.0
        e1, e2, e3 = e1 - mean, e2 - mean, e3 - mean
        value = self._value
        value[0] += free * e1 - common
        value[1] += free * e2 - common
        value[2] += free * e3 - common


class TipFeedback:
    """Shifts lengths so that the seen tip approaches its target, on top of `LengthFeedback`.

    The tip has three coordinates, the section two degrees of freedom: an error along the reachable surface is removed,
    one across it is not in any controller's power (a sagging arm's tips form another surface than the dome).
    """

    def __init__(self, arm: Arm, command: Command, bend: Array, target: Array) -> None:
        assert command.tip_to_bend is not None
        self._target, self._to_bend = target, command.tip_to_bend
        self._spread = length_jacobian(bend, arm)
        self._lengths = LengthFeedback(arm, command.lengths)
        self.time = max(0.2, 2 * self._lengths.time)  # half of it shakes an upright arm with 100 g
        self._offset, self.value = np.zeros(2), np.zeros(3)

    @property
    def memory(self) -> Memory:
        """What has been summed up."""
        return self._offset.copy(), *(self._lengths.memory or ())

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self._offset[:], *lengths = memory or (0.0,)
        self._lengths.memory = tuple(lengths)
        np.add(self._lengths.value, self._lengths.shift, out=self.value)

    def update(self, index: int, seen: Seen, gain: float) -> None:
        """Integrate one interval of sample `index`."""
        self._lengths.update(index, seen, gain * self.time / self._lengths.time)
        self._offset += gain * (self._to_bend[index] @ (self._target[index] - seen.tip))
        self._lengths.shift[:] = self._spread[index] @ self._offset
        np.add(self._lengths.value, self._lengths.shift, out=self.value)


class PressureFeedback:
    """Integrates the error of the measured bend into pressures [Pa], keeping them within the limits.

    The moment that a bend is short of takes tensions, and these pressures, all through the closed forms of the
    commanded bend. Co-contraction stays the least that keeps every muscle at its lowest pressure and tension.
    """

    def __init__(self, arm: Arm, command: Command, bend: Array) -> None:
        self.time = max(0.4, 3 / arm.bend_frequency)  # half of it lets a hanging arm with 100 g swing up by itself
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
        self._offset, self.value = np.zeros(2), np.zeros(3)

    @property
    def memory(self) -> Memory:
        """What has been summed up."""
        return self._offset.copy(), self.value.copy()

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self._offset[:], self.value[:] = memory or (0.0, 0.0)

    def update(self, index: int, seen: Seen, gain: float) -> None:
        """Integrate one interval of sample `index`."""
        self._offset += gain * (self._to_bend[index] @ (self._wanted[index] - seen.lengths))
        base, by_level = self._base[index], self._by_level[index]
        asked = base + self._by_bend[index] @ self._offset
        level = max(((self._least[index] - asked) / by_level).tolist())
        self.value[:] = np.minimum(asked + level * by_level, self._highest) - base


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

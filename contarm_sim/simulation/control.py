"""From bends to servo set-points: closed-form lengths, feed-forward tensions, slow corrections.

Each controller adds one thing to the one before:

    paper        the arc's lengths into plain position servos (they push as well as pull)
    chain        the lengths that the chain of links really has
    feedforward  pulling muscles; tensions that hold the bend fold into the set-point
    servo        an integral on length differences and one on the slackest muscle's tension
    tip          an integral on the tip's position, through the arc's Jacobian, shifts the lengths
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc, chain, muscles
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.statics import holding_tensions, length_jacobian

Controller = Literal["paper", "chain", "feedforward", "servo", "tip"]
CONTROLLERS: tuple[Controller, ...] = get_args(Controller)

INTEGRAL_TIME = 0.1
"""Time constant of the integral corrections [s]: slow beside the servo (0.02 s), fast beside a path."""


TIP_TIME = 0.2
"""Time constant of the tip's feedback [s]; twice what still holds an upright arm with 100 g, which 0.1 s does not."""


@dataclass(frozen=True)
class Command:
    """What the controller works from, computed for all samples at once.

    Attributes:
        lengths: muscle lengths asked for [m], shape (T, 3).
        setpoint: servo set-points before correction [m], shape (T, 3).
        corrected: whether the integral corrections are added.
        pull_only: whether muscles can only pull.
        seeing: whether the tip's position is fed back.
    """

    lengths: Array
    setpoint: Array
    corrected: bool
    pull_only: bool
    seeing: bool


def command(arm: Arm, bend: Array, controller: Controller, period: float | None = None) -> Command:
    """Return lengths and set-points for bends [rad], shape (T, 2).

    Args:
        period: time between the bends [s]. Given, the set-points also carry the servo's and the
            backbone's damping along the motion; None: poses at rest.

    Raises:
        InputError: unknown controller, or a bend that pulling muscles cannot hold.
    """
    if controller not in CONTROLLERS:
        raise InputError("controller", repr(controller), ", ".join(CONTROLLERS))
    if controller == "paper":
        lengths = arm.length + muscles.deltas_from_bend(bend, arm.muscle_radius)
    else:
        lengths = chain.lengths_from_bend(bend, arm.length, arm.muscle_radius, arm.links)
    setpoint = lengths
    forward = controller in ("feedforward", "servo", "tip")
    if forward:
        rate = None
        if period is not None and len(bend) > 1:
            rate = np.gradient(bend, period, axis=0)
            setpoint = setpoint + arm.muscle.servo_time * np.gradient(lengths, period, axis=0)
        setpoint = setpoint - holding_tensions(bend, arm, rate=rate) / arm.muscle.servo_stiffness
    seeing = controller == "tip"
    return Command(lengths, setpoint, controller == "servo" or seeing, pull_only=forward, seeing=seeing)


class Correction:
    """Integral corrections of a set-point [m], shape (3,).

    Only length *differences* are integrated: the common mode of three lengths does not move an inextensible
    backbone, it only makes the muscles fight. The common mode instead keeps the slackest muscle at
    its least tension.
    """

    def __init__(self, arm: Arm) -> None:
        self._least = arm.muscle.min_tension
        self._per_newton = 1 / arm.muscle.servo_stiffness
        self.value = np.zeros(3)

    def update(self, wanted: Array, measured: Array, forces: Array, gain: float) -> None:
        """Integrate one interval from lengths [m] and muscle forces [N] (pulling < 0), each of shape (3,).

        `gain` is the interval over the time constant; 1 corrects fully, as is right at rest.
        """
        # Plain floats: this runs every tick, where three numbers are not worth an array operation.
        w, m = wanted.tolist(), measured.tolist()
        errors = [w[0] - m[0], w[1] - m[1], w[2] - m[2]]
        common = sum(errors) / 3 + (self._least + max(forces.tolist())) * self._per_newton
        for i in (0, 1, 2):
            self.value[i] += gain * (errors[i] - common)


class TipFeedback:
    """Shifts muscle lengths so that the seen tip approaches its target.

    The tip has three coordinates, the section two degrees of freedom: an error along the dome is removed, one across
    it is not in any controller's power (a sagging arm's tips form another surface than the dome).

    Attributes:
        shift: what to add to the lengths asked for [m], shape (3,).
    """

    def __init__(self, arm: Arm, bend: Array, target: Array) -> None:
        self._target = target
        self._inverse = np.linalg.pinv(arc.jacobian(bend, arm.length))
        self._spread = length_jacobian(bend, arm)
        self._offset = np.zeros(2)
        self.shift = np.zeros(3)

    def update(self, index: int, tip: Array, gain: float) -> float:
        """Integrate one interval of sample `index` from the seen tip [m]; return the change of the bend [rad]."""
        change = gain * (self._inverse[index] @ (self._target[index] - tip))
        self._offset += change
        self.shift = self._spread[index] @ self._offset
        return float(np.hypot(change[0], change[1]))

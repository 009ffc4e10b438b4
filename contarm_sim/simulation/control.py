"""From bends to set-points: closed-form lengths, feed-forward tensions, pressures.

Each controller adds one thing to the one before; `feedback` has what those after `feedforward` do as they go:

    paper        the arc's lengths into plain position servos (they push as well as pull)
    chain        the lengths that the chain of links really has
    feedforward  pulling muscles; tensions that hold the bend fold into the set-point
    servo        an integral on length differences and one on the slackest muscle's tension
    pressure     the same through McKibben muscles behind valves: tensions become pressures, the valves' lag is led
    tip          servo, with lengths at which the model's own tip rests on its target, and the seen tip fed back
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import InputError
from contarm_sim.kinematics import chain, muscles
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.statics import holding_pressures, holding_tensions
from contarm_sim.mjcf import Actuation

Controller = Literal["paper", "chain", "feedforward", "servo", "pressure", "tip"]
CONTROLLERS: tuple[Controller, ...] = get_args(Controller)


@dataclass(frozen=True)
class Command:
    """What the controller works from, computed for all samples at once.

    Attributes:
        lengths: muscle lengths asked for [m], shape (T, 3).
        setpoint: servo set-points [m], or pressures [Pa], before feedback, shape (T, 3).
        controller: whose command it is.
    """

    lengths: Array
    setpoint: Array
    controller: Controller

    @property
    def pull_only(self) -> bool:
        """Whether muscles can only pull."""
        return self.controller not in ("paper", "chain")

    @property
    def actuation(self) -> Actuation:
        """What the set-points are."""
        return "pressures" if self.controller == "pressure" else "lengths"


def command(arm: Arm, bend: Array, controller: Controller, period: float | None = None) -> Command:
    """Return lengths and set-points for bends [rad], shape (T, 2).

    Args:
        period: time between the bends [s]. Given, the set-points also carry the servo's or the valve's lag and the
            backbone's damping along the motion; None: poses at rest.

    Raises:
        InputError: unknown controller, or a bend that pulling muscles, or pressures, cannot hold.
    """
    if controller not in CONTROLLERS:
        raise InputError("controller", repr(controller), ", ".join(CONTROLLERS))
    if controller == "paper":
        lengths = arm.length + muscles.deltas_from_bend(bend, arm.muscle_radius)
    else:
        lengths = chain.lengths_from_bend(bend, arm.length, arm.muscle_radius, arm.links)
    if controller in ("paper", "chain"):
        return Command(lengths, lengths, controller)
    moving = period is not None and len(bend) > 1
    rate = np.gradient(bend, period, axis=0) if moving else None
    if controller == "pressure":
        setpoint = holding_pressures(bend, arm, rate=rate)
        lag = arm.muscle.valve_time
    else:
        setpoint = lengths - holding_tensions(bend, arm, rate=rate) / arm.muscle.servo_stiffness
        lag = arm.muscle.servo_time
    if moving:
        followed = setpoint if controller == "pressure" else lengths
        setpoint = setpoint + lag * np.gradient(followed, period, axis=0)
    return Command(lengths, setpoint, controller)

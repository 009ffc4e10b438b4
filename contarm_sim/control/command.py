"""From bends to set-points: closed-form lengths, feed-forward tensions, pressures.

Each controller adds one thing to the one before; `feedback` has what those after `feedforward` do as they go:

    paper        the arc's lengths into plain position servos (they push as well as pull)
    chain        the lengths that the chain of links really has: others than the arc's where muscles run in spans
    feedforward  pulling muscles; tensions that hold the bend fold into the set-point
    servo        an integral on length differences and one on the slackest muscle's tension
    pressure     the same through McKibben muscles behind valves: tensions become pressures, the valves' lag is led
    tip          servo, with lengths at which the model's own tip rests on its target, and the seen tip fed back
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import muscles
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.statics import holding_pressures, holding_tensions, servo_control
from contarm_sim.mjcf import Actuation
from contarm_sim.model.arm import Arm

Controller = Literal["paper", "chain", "feedforward", "servo", "pressure", "tip"]
CONTROLLERS: tuple[Controller, ...] = get_args(Controller)


def pulls_only(controller: Controller) -> bool:
    """Tell whether a controller's muscles can only pull."""
    return controller not in ("paper", "chain")


def actuation_of(controller: Controller) -> Actuation:
    """Return what a controller's set-points are."""
    return "pressures" if controller == "pressure" else "lengths"


@dataclass(frozen=True)
class Command:
    """What the controller works from, computed for all samples at once.

    Attributes:
        lengths: muscle lengths asked for [m], shape (T, 3).
        setpoint: the servos' controls, length changes [m], or pressures [Pa], before feedback, shape (T, 3).
        controller: whose command it is.
        start: set-points that hold the first sample at rest, shape (3,).
        tip_to_bend: change of the bend [rad] by which the resting tip moves as asked for [m], shape (T, 2, 3); the
            `tip` controller's alone.
    """

    lengths: Array
    setpoint: Array
    controller: Controller
    start: Array
    tip_to_bend: Array | None = None

    @property
    def pull_only(self) -> bool:
        """Whether muscles can only pull."""
        return pulls_only(self.controller)

    def limits(self, arm: Arm) -> tuple[float, float] | None:
        """Return the lowest and the highest that set-points may be, or None."""
        return (arm.muscle.min_pressure, arm.muscle.max_pressure) if self.controller == "pressure" else None

    @property
    def actuation(self) -> Actuation:
        """What the set-points are."""
        return actuation_of(self.controller)


def command(arm: Arm, bend: Array, controller: Controller, period: float | None = None) -> Command:
    """Return lengths and set-points for bends [rad], shape (T, 2); `plan` has those of the `tip` controller.

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
        lengths = routing.lengths_from_bend(bend, arm)
    if not pulls_only(controller):
        return Command(lengths, lengths - arm.length, controller, lengths[0] - arm.length)
    start = _hold(arm, bend[:1], lengths[:1], controller, None)[0]
    if period is None or len(bend) < 2:
        return Command(lengths, _hold(arm, bend, lengths, controller, None), controller, start)
    setpoint = _hold(arm, bend, lengths, controller, np.gradient(bend, period, axis=0))
    if controller == "pressure":
        setpoint = setpoint + arm.muscle.valve_time * np.gradient(setpoint, period, axis=0)
    else:
        setpoint = setpoint + arm.servo_time * np.gradient(lengths, period, axis=0)
    return Command(lengths, setpoint, controller, start)


def _hold(arm: Arm, bend: Array, lengths: Array, controller: Controller, rate: Array | None) -> Array:
    """Return set-points [m] or pressures [Pa] with which muscles of these lengths carry the arm."""
    if controller == "pressure":
        return holding_pressures(bend, arm, rate=rate)
    return servo_control(lengths, holding_tensions(bend, arm, rate=rate), arm)

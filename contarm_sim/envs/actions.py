"""What an action means: numbers in [-1, 1] to the engine's controls.

    mode        per action  -1 .. 1 is                                    engine
    bend        2           -170 .. 170 deg of bend along x and y         length servos, feed-forward tensions folded in
    lengths     3           -pi r .. pi r: a change of length [m]         length servos; within their range
    tensions    3           0 .. what holds 170 deg at most: a force [N]  plain forces
    pressures   3           lowest .. highest pressure [Pa]               McKibben muscles behind valves

A change of length is counted from the straight arm; the servo of a muscle that has it pulls with the least tension,
and with more by its gain for every metre that the muscle is longer than asked for. `bend` uses the closed forms of the
arm that the task was made with: lengths of the chain, and the least tensions that hold them under that arm's gravity
and payload. It knows nothing of variations. Bends beyond 170 deg are shortened.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.pressures import level_range
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.mechanics.statics import balance, holding_tensions
from contarm_sim.mjcf import Actuation
from contarm_sim.model.arm import Arm

Mode = Literal["bend", "lengths", "tensions", "pressures"]
MODES: tuple[Mode, ...] = get_args(Mode)


@dataclass(frozen=True)
class Actions:
    """The meaning of actions for one arm.

    Attributes:
        arm: the arm whose closed forms are used.
        mode: bend, lengths, tensions or pressures.
        middle, half: an action a asks for middle + half * a, in the mode's unit.

    Raises:
        InputError: an unknown mode, or an arm that no pulling muscles hold at 170 deg.
    """

    arm: Arm
    mode: Mode
    middle: float = field(init=False)
    half: float = field(init=False)

    def __post_init__(self) -> None:
        low, high = self._limits()
        object.__setattr__(self, "middle", 0.5 * (low + high))
        object.__setattr__(self, "half", 0.5 * (high - low))

    def _limits(self) -> tuple[float, float]:
        arm, muscle = self.arm, self.arm.muscle
        if self.mode not in MODES:
            raise InputError("actions", repr(self.mode), ", ".join(MODES))
        if self.mode == "lengths":
            low, high = arm.setpoint_range
            return max(low, -np.pi * arm.muscle_radius), min(high, np.pi * arm.muscle_radius)
        if self.mode == "pressures":
            return arm.pneumatics.pressure_limits
        farthest = holding_tensions(arc.from_polar(arc.LARGEST_BEND, np.radians(np.arange(0, 360, 15))), arm)
        if self.mode == "tensions":
            return 0.0, min(float(farthest.max()), muscle.blocked_force)
        return -arc.LARGEST_BEND, arc.LARGEST_BEND

    @property
    def size(self) -> int:
        """Numbers in an action."""
        return 2 if self.mode == "bend" else 3

    @property
    def actuation(self) -> Actuation:
        """What drives the model."""
        return "lengths" if self.mode == "bend" else self.mode

    def check(self, action: Any, count: int | None = None) -> Array:
        """Return actions clipped to [-1, 1], shape (B, size); B is `count`, or 1 for one action of shape (size,).

        Raises:
            InputError: another shape, or numbers that are not finite.
        """
        wanted = (self.size,) if count is None else (count, self.size)
        try:
            array = np.asarray(action)
            if array.dtype.kind not in "biuf":
                raise TypeError
            array = array.astype(float)
        except (TypeError, ValueError):
            raise InputError("action", repr(action), f"numbers in [-1, 1], shape {wanted}") from None
        if array.shape != wanted:
            raise InputError("action", f"of shape {array.shape}", f"shape {wanted}, numbers in [-1, 1]")
        if not np.isfinite(array).all():
            raise InputError("action", array.tolist(), "finite numbers in [-1, 1]")
        return array.clip(-1.0, 1.0).reshape(-1, self.size)

    def controls(self, action: Array) -> Array:
        """Return the engine's controls, shape (B, nu), of checked actions, shape (B, size)."""
        asked = self.middle + self.half * action
        if self.mode == "bend":
            return self.setpoints(asked)
        return np.concatenate([asked, asked], axis=-1) if self.mode == "pressures" else asked

    def setpoints(self, bend: Array) -> Array:
        """Return length changes [m], shape (B, 3), that hold bends [rad], shape (B, 2), shortened to 170 deg."""
        arm, bend = self.arm, shortened(bend)
        lengths = routing.lengths_from_bend(bend, arm)
        return servo_control(lengths, holding_tensions(bend, arm), arm)

    def within(self, bends: Array) -> Array:
        """Return bends [rad], shape (T, 2), all shortened alike until the muscles, driven in this mode, hold them."""
        for _ in range(100):
            if self._hold(bends):
                break
            bends = 0.97 * bends
        return bends

    def _hold(self, bends: Array) -> bool:
        if self.mode == "pressures":
            low, high = level_range(balance(bends, self.arm), self.arm)
            return bool(np.all(low <= high))
        if self.mode == "tensions":
            return bool(np.all(holding_tensions(bends, self.arm) <= self.middle + self.half))
        lowest, highest = self.arm.setpoint_range
        setpoints = self.setpoints(bends)
        return bool(np.all((setpoints >= lowest) & (setpoints <= highest)))

    def asking(self, values: Array) -> Array:
        """Return the actions, shape (B, size), that ask for values in the mode's unit, as near as [-1, 1] allows."""
        return ((values - self.middle) / self.half).clip(-1.0, 1.0)


def shortened(bend: Array) -> Array:
    """Return bends [rad], shape (..., 2), those beyond 170 deg shortened to it."""
    angle = np.sqrt(bend[..., 0] * bend[..., 0] + bend[..., 1] * bend[..., 1])
    return bend * (arc.LARGEST_BEND / np.maximum(angle, arc.LARGEST_BEND))[..., None]

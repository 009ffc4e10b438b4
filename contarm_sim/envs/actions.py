"""What an action means: numbers in [-1, 1] to the engine's controls.

    mode        per action  -1 .. 1 is                                    engine
    bend        2 S         -170 .. 170 deg of bend along x and y         length servos, feed-forward tensions folded in
    lengths     n           -pi r .. pi r: a change of length [m]         length servos; within their range
    tensions    n           0 .. what holds 170 deg at most: a force [N]  plain forces
    pressures   n           lowest .. highest pressure [Pa]               McKibben muscles behind valves

S is the number of sections, n that of muscles, section by section; each muscle has the range of its section's, see
`ranges`. A bend may be given as S bends, shape (S, 2), too.

A change of length is counted from the straight arm; the servo of a muscle that has it pulls with the least tension,
and with more by its gain for every metre that the muscle is longer than asked for. `bend` uses the closed forms of the
arm that the task was made with: lengths of the chain, and the least tensions that hold them under that arm's gravity
and payload. It knows nothing of variations. Bends of a section beyond 170 deg are shortened.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from contarm_sim.envs.ranges import action_range
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles, routing
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
        half_turns: what changes of length reach to, in those of half a turn.
        middle, half: an action a asks for middle + half * a, in the mode's unit: one number, or one for each of an
            action's where the muscles of sections differ.

    Raises:
        InputError: an unknown mode, or an arm that no pulling muscles hold at 170 deg.
    """

    arm: Arm
    mode: Mode
    half_turns: float = 1.0
    middle: float | Array = field(init=False, compare=False)
    half: float | Array = field(init=False, compare=False)

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise InputError("actions", repr(self.mode), ", ".join(MODES))
        low, high = action_range(self.arm, self.mode, self.half_turns)
        object.__setattr__(self, "middle", _as_one(0.5 * (low + high)))
        object.__setattr__(self, "half", _as_one(0.5 * (high - low)))

    @property
    def size(self) -> int:
        """Numbers in an action."""
        return 2 * len(self.arm.sections) if self.mode == "bend" else muscles.count(self.arm)

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
        if self.mode == "bend" and len(self.arm.sections) > 1 and array.shape == (*wanted[:-1], self.size // 2, 2):
            array = array.reshape(wanted)
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
        """Return length changes [m], shape (B, n), that hold bends [rad], shape (B, 2 S), shortened to 170 deg."""
        arm, bend = self.arm, shortened(bend)
        lengths = routing.lengths_from_bend(bend, arm)
        return servo_control(lengths, holding_tensions(bend, arm), arm)

    def within(self, bends: Array) -> Array:
        """Return bends [rad], shape (T, 2 S), all shortened alike until the muscles, driven in this mode, hold them."""
        for _ in range(100):
            if self.hold(bends).all():
                break
            bends = 0.97 * bends
        return bends

    def hold(self, bends: Array) -> NDArray[np.bool_]:
        """Tell which bends [rad], shape (T, 2 S), the muscles hold, driven in this mode, shape (T,)."""
        try:
            return self._held(bends)
        except InputError:  # of several sections: no pulling muscles hold some of these bends
            if len(self.arm.sections) == 1:
                raise
            if len(bends) == 1:
                return np.zeros(1, dtype=bool)
            return np.concatenate([self.hold(bend[None]) for bend in bends])

    def _held(self, bends: Array) -> NDArray[np.bool_]:
        if self.mode == "pressures":
            low, high = level_range(balance(bends, self.arm), self.arm)
            return np.asarray((low <= high).all(axis=-1))
        if self.mode == "tensions":
            return np.asarray((holding_tensions(bends, self.arm) <= self.middle + self.half).all(axis=-1))
        lowest = muscles.each(self.arm, lambda group: group.setpoint_range[0])
        highest = muscles.each(self.arm, lambda group: group.setpoint_range[1])
        setpoints = self.setpoints(bends)
        return np.asarray(((setpoints >= lowest) & (setpoints <= highest)).all(axis=-1))

    def asking(self, values: Array) -> Array:
        """Return the actions, shape (B, size), that ask for values in the mode's unit, as near as [-1, 1] allows."""
        return ((values - self.middle) / self.half).clip(-1.0, 1.0)


def action_names(arm: Arm, mode: Mode) -> list[str]:
    """Return a name for each number of an action: `bend_x`, `lengths_2`; with several sections, `bend_2_x`."""
    many, out = len(arm.sections) > 1, []
    bent = [(number, "xy") for number in range(len(arm.sections))]
    pulled = [(group.section, range(1, group.routing.count + 1)) for group in arm.groups]
    for section, own in bent if mode == "bend" else pulled:
        out += [f"{mode}_{section + 1}_{name}" if many else f"{mode}_{name}" for name in own]
    return out


def shortened(bend: Array) -> Array:
    """Return bends [rad], shape (..., 2 S), those of sections beyond 170 deg shortened to it."""
    bends = bend.reshape(*bend.shape[:-1], -1, 2)
    angle = np.sqrt(bends[..., 0] * bends[..., 0] + bends[..., 1] * bends[..., 1])
    return (bends * (arc.LARGEST_BEND / np.maximum(angle, arc.LARGEST_BEND))[..., None]).reshape(bend.shape)


def _as_one(values: Array) -> float | Array:
    """Return the number that all values are, or the values."""
    return float(values[0]) if (values == values[0]).all() else values

"""What stands around an arm that is measured: where its base and markers are, and what the commands drive.

p = position + R(orientation) R(turn) (p_b + R_b offset) is where a marker is measured that sits at `offset` from the
backbone's frame (R_b, p_b) at its place. A muscle is told sign * gain * command - slack, of the channel that drives it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from contarm_sim.brevity import Told
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Muscles
from contarm_sim.model.parameters import Quaternion, Vector, as_number, as_numbers

if TYPE_CHECKING:  # loaded where something is turned
    from scipy.spatial.transform import Rotation

Drive = Literal["windings", "tensions", "pressures", "none"]
DRIVES: tuple[Drive, ...] = get_args(Drive)

ORIGIN: Vector = (0.0, 0.0, 0.0)


def _numbers(values: object, name: str, size: int) -> tuple[float, ...]:
    found = as_numbers(values)
    if found is None or len(found) != size:
        raise InputError(name, values, f"{size} finite numbers")
    return found


@dataclass(frozen=True, kw_only=True, repr=False)
class Marker(Told):
    """A point that is tracked.

    Attributes:
        name: what messages and figures call it.
        xi: the place of the backbone that it turns with, normalised arc length, 0 base to 1 tip.
        offset: from the backbone there, in the backbone's own frame (z along it) [m].

    Raises:
        InputError: a place off the arm, or not three finite numbers.
    """

    name: str = "tip"
    xi: float = 1.0
    offset: Vector = ORIGIN

    def __post_init__(self) -> None:
        if not 0 <= as_number(self.xi) <= 1:
            raise InputError(f"marker {self.name}.xi", self.xi, "a number from 0 (base) to 1 (tip)")
        object.__setattr__(self, "xi", as_number(self.xi))
        object.__setattr__(self, "offset", _numbers(self.offset, f"marker {self.name}.offset", 3))


@dataclass(frozen=True, kw_only=True, repr=False)
class Actuation(Told):
    """How commands drive the muscles.

    Attributes:
        drive: what a muscle is told: the length that its winch winds in (`windings` [m]), a tension [N], a gauge
            pressure [Pa]; or nothing (`none`).
        channels: of the command that drives each muscle, from 0, muscles section by section; one channel may drive
            several.
        signs: 1, or -1 where the channel lets out what it winds in elsewhere, one for each muscle; default all 1.
        gains: what one unit of each channel's command is worth, such as the radius of a pulley [m/rad]; default all 1.
        slack: what is wound in before a muscle of the straight arm is taut [m]; the dead band of tensions [N] and
            pressures [Pa]. One for each muscle; less than 0: mounted under tension. Default all 0.

    Raises:
        InputError: an unknown drive, or lists that do not fit together.
    """

    drive: Drive = "windings"
    channels: tuple[int, ...] = ()
    signs: tuple[float, ...] = ()
    gains: tuple[float, ...] = ()
    slack: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.drive not in DRIVES:
            raise InputError("actuation.drive", repr(self.drive), ", ".join(DRIVES))
        count = len(self.channels)
        if any(isinstance(channel, bool) or not isinstance(channel, int) or channel < 0 for channel in self.channels):
            raise InputError("actuation.channels", self.channels, "whole numbers from 0")
        object.__setattr__(self, "channels", tuple(self.channels))
        sizes = {"signs": (count, 1.0), "gains": (max(self.channels, default=-1) + 1, 1.0), "slack": (count, 0.0)}
        for name, (size, usual) in sizes.items():
            given = getattr(self, name) or (usual,) * size
            if name == "gains" and len(given) > size:
                size = len(given)  # channels that drive nothing
            object.__setattr__(self, name, _numbers(given, f"actuation.{name}", size))
        if any(abs(sign) != 1 for sign in self.signs):
            raise InputError("actuation.signs", self.signs, "1 or -1 for each muscle")

    def values(self, commands: Array) -> Array:
        """Return what the muscles are told, shape (..., M), in the units of `muscles`.

        Args:
            commands: of the channels, shape (..., C).
        """
        own = list(self.channels)
        told = np.array(self.signs) * np.array(self.gains)[own] * np.asarray(commands)[..., own] - np.array(self.slack)
        return -told if self.drive == "windings" else np.maximum(told, 0.0)

    def muscles(self, values: Array) -> Muscles:
        """Return how muscles are driven that are told these values, shape (M,), of one sample."""
        if self.drive == "none":
            return Muscles()
        kind = "setpoints" if self.drive == "windings" else self.drive
        return Muscles(kind=kind, values=tuple(values.tolist()))


@dataclass(frozen=True, kw_only=True, repr=False)
class Rig(Told):
    """What stands around an arm that is measured.

    Attributes:
        markers: that are tracked, in the order of a recording.
        actuation: how commands drive the muscles.
        position: of the arm's base in the frame of the measurements [m].
        orientation: of the base there, a quaternion w x y z.
        turn: a rotation vector about the base's own axes [rad], on top of `orientation`: what a fit corrects.
        gravity: in the frame of the measurements [m/s^2]; None: as the arm says, in its base's.

    Raises:
        InputError: not finite numbers, a quaternion of zeros, or no markers.
    """

    markers: tuple[Marker, ...] = (Marker(),)
    actuation: Actuation = field(default_factory=Actuation)
    position: Vector = ORIGIN
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)
    turn: Vector = ORIGIN
    gravity: Vector | None = None

    def __post_init__(self) -> None:
        if not self.markers:
            raise InputError("markers", "none", "one marker or more")
        object.__setattr__(self, "markers", tuple(self.markers))
        for name in ("position", "turn"):
            object.__setattr__(self, name, _numbers(getattr(self, name), f"frame.{name}", 3))
        if self.gravity is not None:
            object.__setattr__(self, "gravity", _numbers(self.gravity, "frame.gravity", 3))
        turned = _numbers(self.orientation, "frame.orientation", 4)
        norm = math.hypot(*turned)
        if norm == 0:
            raise InputError("frame.orientation", self.orientation, "a quaternion w x y z, not zero")
        if not math.isclose(norm, 1.0, rel_tol=1e-15):  # a rig that was saved and loaded keeps its bits
            turned = tuple(x / norm for x in turned)
        object.__setattr__(self, "orientation", turned)

    @property
    def rotation(self) -> Array:
        """Of the base in the frame of the measurements, shape (3, 3)."""
        return np.asarray(self._turned().as_matrix())

    def settled(self) -> Rig:
        """Return the same rig with `turn` taken into `orientation`."""
        if not any(self.turn):
            return self
        x, y, z, w = self._turned().as_quat().tolist()
        return replace(self, orientation=(w, x, y, z), turn=ORIGIN)

    def _turned(self) -> Rotation:
        from scipy.spatial.transform import Rotation

        w, x, y, z = self.orientation
        return Rotation.from_quat((x, y, z, w)) * Rotation.from_rotvec(self.turn)

    def holds(self, arm: Arm) -> Arm:
        """Return the arm under the gravity that it has in this rig."""
        if self.gravity is None:
            return arm
        x, y, z = (self.rotation.T @ np.array(self.gravity)).tolist()
        return arm.in_world(replace(arm.world, gravity=(x, y, z)))

    def measured(self, frames: Array) -> Array:
        """Return where markers are measured [m], shape (..., K, 3).

        Args:
            frames: 4x4 frames of the backbone at the markers' places, in the base's frame, shape (..., K, 4, 4).
        """
        offsets = np.array([marker.offset for marker in self.markers])
        points = frames[..., :3, 3] + (frames[..., :3, :3] @ offsets[..., None])[..., 0]
        return np.asarray(points @ self.rotation.T + np.array(self.position))

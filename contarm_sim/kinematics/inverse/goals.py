"""What tips are to reach: positions, and directions or rotations beside them; how far they are off, and its slopes.

Residuals are free of units: distances are divided by the backbone's length, angles count as `ANGLE_LENGTH`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH

FARTHEST = 1e6
"""Farthest target that is taken, in backbone lengths."""

_ROUNDED = 1e-2  # a quaternion or direction typed with two decimals is one


@dataclass(frozen=True)
class Goals:
    """Goals of n tips.

    Attributes:
        position: where the tips are to be [m], shape (n, 3).
        direction: unit vectors that the z axes of the tips are to have, shape (n, 3), or None.
        rotation: what the tips are to be turned by, shape (n, 3, 3), or None.
    """

    position: Array
    direction: Array | None = None
    rotation: Array | None = None

    def __len__(self) -> int:
        return len(self.position)

    @property
    def conditions(self) -> int:
        """How many numbers of a tip's pose are asked for: 3, 5 or 6."""
        return 3 if self.direction is None and self.rotation is None else 5 if self.rotation is None else 6

    def take(self, rows: Any) -> Goals:
        """Return some of the goals, by an index array, a mask or a slice."""
        direction = None if self.direction is None else self.direction[rows]
        rotation = None if self.rotation is None else self.rotation[rows]
        return Goals(self.position[rows], direction, rotation)

    def turn(self, rotation: Array) -> Array | None:
        """Return the rotation vectors that turn tips into what is asked for [rad], shape (n, 3), or None."""
        if self.rotation is not None:
            return _log(self.rotation @ rotation.swapaxes(-1, -2))
        if self.direction is not None:
            axis = rotation[..., 2]
            lateral = np.cross(axis, self.direction)
            return _scaled(lateral, (axis * self.direction).sum(axis=-1))
        return None

    def misses(self, position: Array, rotation: Array) -> tuple[Array, Array]:
        """Return the distances [m] and the angles [rad] from tips to goals, each of shape (n,)."""
        distance = np.sqrt(((self.position - position) ** 2).sum(axis=-1))
        turn = self.turn(rotation)
        return distance, np.zeros(len(distance)) if turn is None else np.sqrt((turn**2).sum(axis=-1))

    def residual(self, position: Array, rotation: Array, length: float) -> Array:
        """Return goal minus tip, free of units, shape (n, 3) or (n, 6)."""
        offset = (self.position - position) / length
        turn = self.turn(rotation)
        return offset if turn is None else np.concatenate([offset, ANGLE_LENGTH * turn], axis=-1)

    def rows(self, jacobian: Array, rotation: Array, length: float) -> Array:
        """Return how `residual` falls by the bends, shape (n, 3 or 6, 2 S): exact where it is 0.

        Times the residual, it gives the exact gradient of half its square everywhere.
        """
        if self.direction is None and self.rotation is None:
            return jacobian[:, :3] / length
        out = np.empty_like(jacobian)
        out[:, :3], out[:, 3:] = jacobian[:, :3] / length, ANGLE_LENGTH * jacobian[:, 3:]
        if self.rotation is None:
            axis = rotation[..., 2]
            out[:, 3:] -= axis[:, :, None] * (axis[:, None, :] @ out[:, 3:])
        return out


def as_goals(position: Any, direction: Any, rotation: Any, length: float) -> tuple[Goals, tuple[int, ...]]:
    """Return checked goals, and the leading axes that their arrays share.

    Raises:
        InputError: wrong shapes, not finite, farther than `FARTHEST`, a direction of length 0, no rotation, or both.
    """
    position = as_vectors(position, 3, "position")
    if np.any(np.abs(position) > FARTHEST * length):
        worst = position[(np.abs(position) > FARTHEST * length).any(axis=-1)][0]
        raise InputError("position", worst.tolist(), f"within {FARTHEST:g} backbone lengths")
    if direction is not None and rotation is not None:
        raise InputError("orientation", "both a direction and a rotation", "at most one of them")
    shape = position.shape[:-1]
    if direction is not None:
        direction = as_directions(direction)
        shape = _broadcast("direction", shape, direction.shape[:-1])
        direction = np.broadcast_to(direction, (*shape, 3)).reshape(-1, 3)
    if rotation is not None:
        rotation = as_rotations(rotation)
        shape = _broadcast("rotation", shape, rotation.shape[:-2])
        rotation = np.broadcast_to(rotation, (*shape, 3, 3)).reshape(-1, 3, 3)
    return Goals(np.broadcast_to(position, (*shape, 3)).reshape(-1, 3), direction, rotation), shape


def as_directions(value: Any) -> Array:
    """Return directions as unit vectors, shape (..., 3).

    Raises:
        InputError: not finite, of another shape, or of length 0.
    """
    value = as_vectors(value, 3, "direction")
    largest = np.abs(value).max(axis=-1, initial=0.0)
    if not np.all(largest > 0):
        raise InputError("direction", [0.0, 0.0, 0.0], "a vector that is not 0")
    value = value / largest[..., None]
    return np.asarray(value / np.linalg.norm(value, axis=-1, keepdims=True))


def as_rotations(value: Any) -> Array:
    """Return rotation matrices, shape (..., 3, 3).

    Raises:
        InputError: not finite, of another shape, not orthonormal to 1e-6, or mirrored.
    """
    value = as_vectors(value, 3, "rotation")
    if value.ndim < 2 or value.shape[-2] != 3:
        raise InputError("rotation", f"of shape {value.shape}", "shape (..., 3, 3)")
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(value @ value.swapaxes(-1, -2) - np.eye(3)).max(axis=(-1, -2), initial=0.0)
    if not np.all(off <= 1e-6):
        raise InputError("rotation", value[~(off <= 1e-6)][0].tolist(), "orthonormal rows to 1e-6")
    if not np.all(np.linalg.det(value) > 0):
        raise InputError("rotation", "a mirror image (determinant -1)", "a rotation, determinant 1")
    return value


def rotation_from_quaternion(quaternion: Any) -> Array:
    """Return rotation matrices, shape (..., 3, 3), of unit quaternions w x y z, shape (..., 4); -q is the same as q.

    Raises:
        InputError: not finite, of another shape, or of a norm that is not 1 to a hundredth.
    """
    quaternion = as_vectors(quaternion, 4, "quaternion")
    with np.errstate(over="ignore"):
        norm = np.linalg.norm(quaternion, axis=-1)
    if not np.all(np.abs(norm - 1) <= _ROUNDED):
        worst = quaternion[~(np.abs(norm - 1) <= _ROUNDED)][0].tolist()
        raise InputError("quaternion", worst, "a unit quaternion w x y z, its norm 1 to a hundredth")
    w, x, y, z = np.moveaxis(quaternion / norm[..., None], -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def _broadcast(name: str, shape: tuple[int, ...], other: tuple[int, ...]) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(shape, other)
    except ValueError:
        raise InputError(name, f"with leading axes {other}", f"those of the positions, {shape}") from None


def _log(rotation: Array) -> Array:
    """Return rotation vectors, shape (..., 3), up to half a turn; there the axis is that of the largest diagonal."""
    twice = np.stack(
        [
            rotation[..., 2, 1] - rotation[..., 1, 2],
            rotation[..., 0, 2] - rotation[..., 2, 0],
            rotation[..., 1, 0] - rotation[..., 0, 1],
        ],
        axis=-1,
    )
    return _scaled(0.5 * twice, 0.5 * (np.trace(rotation, axis1=-2, axis2=-1) - 1))


def _scaled(sines: Array, cosine: Array) -> Array:
    """Return angle * axis of sin(angle) * axis and cos(angle); where the axis is lost, at half a turn, about x."""
    sine = np.sqrt((sines**2).sum(axis=-1))
    lost = (sine < 1e-9) & (cosine < 0)
    if lost.any():
        sines, sine = np.where(lost[..., None], (1e-9, 0.0, 0.0), sines), np.where(lost, 1e-9, sine)
    angle = np.arctan2(sine, cosine)
    return np.asarray(np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 1.0)[..., None] * sines)

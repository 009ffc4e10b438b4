"""Rotations as tips are asked for them: from quaternions and directions, to and from rotation vectors."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_vectors

_ROUNDED = 1e-2  # a quaternion typed with two decimals is one


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


def rotation_to(direction: Array) -> Array:
    """Return rotations whose last columns are unit vectors, shape (n, 3, 3): the turns of least angle from e3."""
    x, y, z = direction.T
    out = np.empty((len(direction), 3, 3))
    down = z < -1 + 1e-12  # any half-turn about a level axis will do
    share = 1 / np.where(down, 1.0, 1 + z)
    out[:, 0, 0], out[:, 1, 1], out[:, 0, 1] = 1 - share * x * x, 1 - share * y * y, -share * x * y
    out[:, 1, 0] = out[:, 0, 1]
    out[:, 2, 0], out[:, 2, 1] = -x, -y
    out[down] = np.diag([1.0, -1.0, -1.0])
    out[:, :, 2] = direction
    return out


def between_rotations(first: Array, last: Array) -> Array:
    """Return the rotation vectors [rad], shape (..., 3), that turn rotations into others; up to half a turn."""
    R = last @ first.swapaxes(-1, -2)
    twice = [R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]]
    return _scaled(0.5 * np.stack(twice, axis=-1), 0.5 * (np.trace(R, axis1=-2, axis2=-1) - 1))


def between_directions(first: Array, last: Array) -> Array:
    """Return the rotation vectors [rad], shape (..., 3), that turn unit vectors into others the shortest way."""
    return _scaled(np.cross(first, last), (first * last).sum(axis=-1))


def turned(vector: Array) -> Array:
    """Return the rotations of rotation vectors [rad], shape (n, 3, 3)."""
    angle = np.sqrt((vector**2).sum(axis=-1))
    x, y, z = (vector / np.maximum(angle, 1e-300)[:, None]).T
    zero = np.zeros_like(x)
    hat = np.moveaxis(np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]), -1, 0)
    return np.asarray(np.eye(3) + np.sin(angle)[:, None, None] * hat + (1 - np.cos(angle))[:, None, None] * hat @ hat)


def _scaled(sines: Array, cosine: Array) -> Array:
    """Return angle * axis of sin(angle) * axis and cos(angle); where the axis is lost, at half a turn, about x."""
    sine = np.sqrt((sines**2).sum(axis=-1))
    lost = (sine < 1e-9) & (cosine < 0)
    if lost.any():
        sines, sine = np.where(lost[..., None], (1e-9, 0.0, 0.0), sines), np.where(lost, 1e-9, sine)
    angle = np.arctan2(sine, cosine)
    return np.asarray(np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 1.0)[..., None] * sines)

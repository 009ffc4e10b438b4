"""Three sections' pose and Jacobian in one go, and Newton's method on them: from a few digits to rounding.

By half turns: a chord u = (sinc(h) bend/2, cos h), h half the bend angle, moves the end by rho u and turns it by
H(u) H(e3); as u changes, it turns by 2 u x du.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array, sinc_and_slope
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH

SOLVED = 1e-13
"""Miss of a solution, as a fraction of the length; Newton's method leaves rounding, mostly below 1e-15."""

_STEPS = 30
_ROUNDING = 4e-16
_LONGEST = 0.5  # of a step [rad]


def newton(position: Array, rotation: Array, bends: Array, backbone: Backbone,
           least_singular: float = 0.0) -> tuple[Array, Array, Array]:  # fmt: skip
    """Return bends that reach the pose [rad], their misses as fractions of the length, shape (n,), and Jacobians.

    Args:
        position: targets [m], shape (n, 3).
        rotation: targets, shape (n, 3, 3).
        bends: starts [rad], shape (n, 3, 2).
        backbone: three sections, no connectors.
        least_singular: directions of smaller singular values, as a fraction of the largest, are left alone.
    """
    best, least, jacobians = bends, np.full(len(bends), np.inf), np.zeros((len(bends), 6, 6))
    at, going = bends, np.arange(len(bends))
    for _ in range(_STEPS):
        off, J = misses(position[going], rotation[going], at, backbone)
        size = np.sqrt(np.sum(off * off, axis=-1))
        better = size < least[going]
        if better.all() and len(going) == len(bends):
            best, least, jacobians = at, size, J
        else:
            if len(going) == len(bends):
                best, least, jacobians = best.copy(), least.copy(), jacobians.copy()
            which = going[better]
            best[which], least[which], jacobians[which] = at[better], size[better], J[better]
        # A step from 1e-8 leaves rounding; what stays above it is nearly singular, and comes closer by halves.
        on = (size > _ROUNDING) & (better | (size > SOLVED)) & (size < 10)
        if not on.any():
            break
        if not on.all():
            going, at, off, J = going[on], at[on], off[on], J[on]
        at = at - _short(_solved(J, off, least_singular)).reshape(at.shape)
    return best, least, jacobians


def misses(position: Array, rotation: Array, bends: Array, backbone: Backbone) -> tuple[Array, Array]:
    """Return what bends miss, shape (n, 6), and its Jacobian, shape (n, 6, 6), as fractions of the length.

    The distance, then the rotation vector from the target to what is reached, times 0.3.
    """
    size = backbone.length
    p, R, J = pose_and_jacobian(bends, backbone)
    off = np.empty((len(bends), 6))
    off[:, :3] = (p - position) / size
    turn = R @ rotation.swapaxes(-1, -2)
    off[:, 3] = turn[:, 2, 1] - turn[:, 1, 2]
    off[:, 4] = turn[:, 0, 2] - turn[:, 2, 0]
    off[:, 5] = turn[:, 1, 0] - turn[:, 0, 1]
    # The vector is sin of the angle long; beyond a quarter turn it would shrink again.
    backward = turn[:, 0, 0] + turn[:, 1, 1] + turn[:, 2, 2] < 1
    off[:, 3:] *= 0.5 * ANGLE_LENGTH
    if backward.any():
        axis = off[backward, 3:]
        sine = np.linalg.norm(axis, axis=-1, keepdims=True)
        # A half-turn says no axis here, and any will do.
        off[backward, 3:] = ANGLE_LENGTH * np.where(sine > 1e-9, axis / np.maximum(sine, 1e-9), [1.0, 0.0, 0.0])
    J[:, :3] /= size
    J[:, 3:] *= ANGLE_LENGTH
    return off, J


def pose_and_jacobian(bends: Array, backbone: Backbone) -> tuple[Array, Array, Array]:
    """Return positions [m], rotations and geometric Jacobians of the end, shapes (n, 3), (n, 3, 3), (n, 6, 6)."""
    count = len(bends)
    y = 0.25 * np.sum(bends * bends, axis=-1)
    c, g = sinc_and_slope(y)
    u = np.empty((count, 3, 3))
    u[..., :2] = 0.5 * c[..., None] * bends
    u[..., 2] = c + y * g
    du = np.empty((count, 3, 3, 2))
    du[..., :2, :] = (0.125 * g)[..., None, None] * bends[..., :, None] * bends[..., None, :]
    du[..., 0, 0] += 0.5 * c
    du[..., 1, 1] += 0.5 * c
    du[..., 2, :] = -0.25 * c[..., None] * bends
    rho, rate = c, 0.25 * g
    if backbone.links is not None:
        links = np.asarray(backbone.links, dtype=float)
        short, slope = _shrunk(y / links**2)
        rho, rate = c * short, rate * short + 0.5 * c * slope / links**2
    lengths = np.asarray(backbone.lengths)
    rho, rate = rho * lengths, rate * lengths
    moves = rho[..., None, None] * du + u[..., :, None] * (rate[..., None] * bends)[..., None, :]
    turns = 2 * _cross(u[..., None], du)
    # H(u) H(e3): columns 2 ux u - ex and 2 uy u - ey with their signs changed, 2 uz u - ez
    R = 2 * u[..., :, None] * (u * np.array([-1.0, -1.0, 1.0]))[..., None, :]
    R[..., 0, 0] += 1
    R[..., 1, 1] += 1
    R[..., 2, 2] -= 1
    chord = rho[..., None] * u
    second = R[:, 0] @ R[:, 1]
    chord[:, 1] = (R[:, 0] @ chord[:, 1, :, None])[..., 0]
    chord[:, 2] = (second @ chord[:, 2, :, None])[..., 0]
    J = np.empty((count, 6, 3, 2))
    parts = np.concatenate([moves, turns], axis=-1)
    parts[:, 1] = R[:, 0] @ parts[:, 1]
    parts[:, 2] = second @ parts[:, 2]
    lever = np.zeros((count, 3, 3))
    lever[:, 1] = chord[:, 2]
    lever[:, 0] = chord[:, 1] + chord[:, 2]
    spin = parts[..., 2:]
    moved = parts[..., :2] + _cross(spin, lever[..., None])
    J[:, :3] = moved.swapaxes(1, 2)
    J[:, 3:] = spin.swapaxes(1, 2)
    return lever[:, 0] + chord[:, 0], second @ R[:, 2], J.reshape(count, 6, 6)


def _shrunk(y: Array) -> tuple[Array, Array]:
    """Return x cot x of y = x^2, and its derivative by y."""
    c, g = sinc_and_slope(y)
    cosine = c + y * g
    return cosine / c, -0.5 * (1 + cosine * g / (c * c))


def _cross(a: Array, b: Array) -> Array:
    """Return cross products of vectors along the axis before the last."""
    ax, ay, az = a[..., 0, :], a[..., 1, :], a[..., 2, :]
    bx, by, bz = b[..., 0, :], b[..., 1, :], b[..., 2, :]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-2)


def _solved(J: Array, off: Array, least_singular: float) -> Array:
    if least_singular == 0:
        try:
            return np.asarray(np.linalg.solve(J, off[..., None])[..., 0])
        except np.linalg.LinAlgError:
            least_singular = 1e-12
    return np.asarray((np.linalg.pinv(J, rcond=least_singular) @ off[..., None])[..., 0])


def _short(step: Array) -> Array:
    length = np.sqrt(np.sum(step * step, axis=-1, keepdims=True))
    return np.asarray(step * np.minimum(1.0, _LONGEST / (length + 1e-300)))

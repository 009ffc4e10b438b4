"""The constant-curvature arc in closed form: bend to pose, and its Jacobian.

`bend` is bend_angle * (cos plane_angle, sin plane_angle) [rad], shape (..., 2). With
s = xi |bend| and h = s/2 the pose of the arc at normalised arc length xi is

    p = xi length ( (xi/2) sinc(h)^2 bend, sinc(s) )
    R = exp(xi [-bend_y, bend_x, 0]^)

the paper's transform (eq. 15-16) with its last factor mended, written so that nothing
divides by |bend|: every formula is smooth through the straight pose. Leading axes
broadcast. See `dome` for the inverse.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_vectors, as_xi, sinc, sinc_slope


def as_bend(bend: Any) -> Array:
    """Return bend vectors [rad] as an array of shape (..., 2), each shorter than pi.

    Raises:
        InputError: not finite, of the wrong shape, or a bend angle of pi or more.
    """
    bend = as_vectors(bend, 2, "bend")
    angle = np.hypot(bend[..., 0], bend[..., 1])
    if not np.all(angle < np.pi):
        worst = float(angle.max())
        raise InputError("bend_angle", f"{worst:.9g} rad ({np.degrees(worst):.6g} deg)", "0 <= bend_angle < pi rad")
    return bend


def from_polar(bend_angle: Any, plane_angle: Any) -> Array:
    """Return the bend vector [rad], shape (..., 2), of a bend angle in its bending plane [rad].

    Raises:
        InputError: a bend angle outside [0, pi), or a number that is not finite.
    """
    bend_angle, plane_angle = np.broadcast_arrays(np.asarray(bend_angle, float), np.asarray(plane_angle, float))
    if not np.all(np.isfinite(plane_angle)):
        raise InputError("plane_angle", plane_angle.tolist(), "finite numbers [rad]")
    if not np.all((bend_angle >= 0) & (bend_angle < np.pi)):
        raise InputError("bend_angle", bend_angle.tolist(), "0 <= bend_angle < pi rad")
    return np.stack([bend_angle * np.cos(plane_angle), bend_angle * np.sin(plane_angle)], axis=-1)


def to_polar(bend: Any) -> tuple[Array, Array]:
    """Return (bend_angle in [0, pi), plane_angle in (-pi, pi]) [rad], each of shape (...)."""
    bend = as_vectors(bend, 2, "bend")
    return np.hypot(bend[..., 0], bend[..., 1]), np.arctan2(bend[..., 1], bend[..., 0]) + 0.0


def position(bend: Any, length: float, xi: Any = 1.0) -> Array:
    """Return points of the arc [m], shape (..., 3); `xi` broadcasts against the leading axes of `bend`."""
    bend, xi = as_vectors(bend, 2, "bend"), as_xi(xi)
    s = xi * np.hypot(bend[..., 0], bend[..., 1])
    out = np.empty((*s.shape, 3))
    out[..., :2] = (0.5 * length * xi**2 * sinc(0.5 * s) ** 2)[..., None] * bend
    out[..., 2] = length * xi * sinc(s)
    return out


def rotation(bend: Any, xi: Any = 1.0) -> Array:
    """Return orientations of the arc's frames in the base frame, shape (..., 3, 3), torsion-free."""
    bend, xi = as_vectors(bend, 2, "bend"), as_xi(xi)
    s = xi * np.hypot(bend[..., 0], bend[..., 1])
    bx, by = xi * bend[..., 0], xi * bend[..., 1]
    half = 0.5 * sinc(0.5 * s) ** 2
    full = sinc(s)
    R = np.empty((*s.shape, 3, 3))
    R[..., 0, 0] = 1 - half * bx * bx
    R[..., 1, 1] = 1 - half * by * by
    R[..., 0, 1] = R[..., 1, 0] = -half * bx * by
    R[..., 0, 2] = full * bx
    R[..., 1, 2] = full * by
    R[..., 2, 0] = -R[..., 0, 2]
    R[..., 2, 1] = -R[..., 1, 2]
    R[..., 2, 2] = np.cos(s)
    return R


def transform(bend: Any, length: float, xi: Any = 1.0) -> Array:
    """Return `transform_tip_to_base` (for xi < 1: of the frame at xi), shape (..., 4, 4)."""
    p = position(bend, length, xi)
    T = np.zeros((*p.shape[:-1], 4, 4))
    T[..., :3, :3] = rotation(bend, xi)
    T[..., :3, 3] = p
    T[..., 3, 3] = 1.0
    return T


def jacobian(bend: Any, length: float, xi: Any = 1.0) -> Array:
    """Return dp/dbend [m/rad], shape (..., 3, 2): the closed-form derivative of `position`."""
    bend, xi = as_vectors(bend, 2, "bend"), as_xi(xi)
    s = xi * np.hypot(bend[..., 0], bend[..., 1])
    h = 0.5 * s
    c = sinc(h)
    lateral = 0.5 * length * xi**2 * c**2
    curving = 0.25 * length * xi**4 * c * sinc_slope(h)
    J = np.empty((*s.shape, 3, 2))
    J[..., :2, :] = lateral[..., None, None] * np.eye(2)
    J[..., :2, :] += curving[..., None, None] * bend[..., :, None] * bend[..., None, :]
    J[..., 2, :] = (length * xi**3 * sinc_slope(s))[..., None] * bend
    return J

"""The constant-curvature arc in closed form: bend to pose, and its Jacobian.

`bend` is bend_angle * (cos plane_angle, sin plane_angle) [rad], shape (..., 2). With
h = xi |bend|/2, c = sin(h)/h and k = cos(h) the pose of the arc at normalised arc length xi is

    p = xi length ( (xi/2) c^2 bend, c k )
    R = exp(xi [-bend_y, bend_x, 0]^)

the paper's transform (eq. 15-16) with its last factor mended, written so that nothing
divides by |bend|: every formula is smooth through the straight pose. Leading axes
broadcast. See `dome` for the inverse.

Inside loops, `check=False` leaves out the checks of `position`, `rotation`, `transform` and
`jacobian`; what is not finite then gives what is not finite, and an xi off [0, 1] lies off the arc.
"""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import FEW, Array, Number, as_vectors, as_xi, blocks, sinc_and_slope

LARGEST_BEND = float(np.radians(170))
"""Largest bend angle that studies, actions and the live page go to [rad]."""


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


def one_bend(bend: Any) -> Array:
    """Return one bend vector [rad], shape (2,), shorter than pi.

    Raises:
        InputError: as `as_bend`, or several bends.
    """
    bend = as_bend(bend)
    if bend.ndim != 1:
        raise InputError("bend", f"of shape {bend.shape}", "one bend, shape (2,)")
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


def position(bend: Any, length: float, xi: Any = 1.0, *, check: bool = True) -> Array:
    """Return points of the arc [m], shape (..., 3); `xi` broadcasts against the leading axes of `bend`."""
    return _evaluate(_position, (3,), bend, length, xi, check)


def rotation(bend: Any, xi: Any = 1.0, *, check: bool = True) -> Array:
    """Return orientations of the arc's frames in the base frame, shape (..., 3, 3), torsion-free."""
    return _evaluate(_rotation, (3, 3), bend, 1.0, xi, check)


def transform(bend: Any, length: float, xi: Any = 1.0, *, check: bool = True) -> Array:
    """Return `transform_tip_to_base` (for xi < 1: of the frame at xi), shape (..., 4, 4)."""
    return _evaluate(_transform, (4, 4), bend, length, xi, check)


def jacobian(bend: Any, length: float, xi: Any = 1.0, *, check: bool = True) -> Array:
    """Return dp/dbend [m/rad], shape (..., 3, 2): the closed-form derivative of `position`."""
    return _evaluate(_jacobian, (3, 2), bend, length, xi, check)


# The formulas, of floats or of equal arrays: bend times xi, length times xi, xi; they return the entries row by row.
Formula = Callable[[Any, Any, Any, Any], tuple[Any, ...]]


def _evaluate(formula: Formula, entries: tuple[int, ...], bend: Any, length: float, xi: Any, check: bool) -> Array:
    """Fill an array of shape (..., *entries) with a formula, block by block."""
    if check:
        bend, xi = as_vectors(bend, 2, "bend"), as_xi(xi)
    else:
        bend, xi = np.asarray(bend, dtype=float), np.asarray(xi, dtype=float)
    shape = bend.shape[:-1]
    if xi.ndim:
        shape = np.broadcast_shapes(shape, xi.shape)
        bend, xi = np.broadcast_to(bend, (*shape, 2)), np.broadcast_to(xi, shape)
    rows, each = bend.reshape(-1, 2), xi.reshape(-1) if xi.ndim else xi.item()
    out = np.empty((len(rows), prod(entries)))
    if len(rows) <= FEW:
        for i, (bx, by) in enumerate(rows.tolist()):
            x = each.item(i) if xi.ndim else each
            out[i] = formula(x * bx, x * by, x * length, x)
    else:
        for block in blocks(len(rows)):
            x = each[block] if xi.ndim else each
            part = out[block]
            for column, values in enumerate(formula(x * rows[block, 0], x * rows[block, 1], x * length, x)):
                part[:, column] = values
    return out.reshape(*shape, *entries)


def _position(bx: Number, by: Number, length: Any, xi: Any) -> tuple[Any, ...]:
    y = 0.25 * (bx * bx + by * by)
    c, g = sinc_and_slope(y)
    lateral = (0.5 * length) * (c * c)
    return lateral * bx, lateral * by, length * (c * (c + y * g))


def _rotation(bx: Number, by: Number, length: Any, xi: Any) -> tuple[Any, ...]:
    return _frame(bx, by)[0]


def _transform(bx: Number, by: Number, length: Any, xi: Any) -> tuple[Any, ...]:
    (xx, xy, xz, yx, yy, yz, zx, zy, zz), half, full = _frame(bx, by)
    lateral = length * half
    return xx, xy, xz, lateral * bx, yx, yy, yz, lateral * by, zx, zy, zz, length * full, 0.0, 0.0, 0.0, 1.0


def _frame(bx: Number, by: Number) -> tuple[tuple[Any, ...], Any, Any]:
    """Return the rotation's entries, (1 - cos s)/s^2 and sin(s)/s of s = |bend|."""
    y = 0.25 * (bx * bx + by * by)
    c, g = sinc_and_slope(y)
    half, full = 0.5 * (c * c), c * (c + y * g)
    hx, xz, yz = half * bx, full * bx, full * by
    xx, xy, yy = hx * bx, -(hx * by), half * by * by
    return (1 - xx, xy, xz, xy, 1 - yy, yz, -xz, -yz, 1 - (xx + yy)), half, full


def _jacobian(bx: Number, by: Number, length: Any, xi: Any) -> tuple[Any, ...]:
    y = 0.25 * (bx * bx + by * by)
    c, g = sinc_and_slope(y)
    squared, scale = c * c, xi * length
    lateral = (0.5 * scale) * squared
    curving = (0.25 * scale) * (c * g)
    falling = (0.25 * scale) * (g * (c + y * g) - squared)
    cx = curving * bx
    mixed = cx * by
    return lateral + cx * bx, mixed, mixed, lateral + curving * by * by, falling * bx, falling * by


def described(bend: Any) -> str:
    """Return a bend [rad], shape (2,), in words, in degrees."""
    angle, plane = (float(np.degrees(x)) for x in to_polar(bend))
    return f"a bend of {angle:.0f} deg towards {plane:.0f} deg"

"""The tip of two sections and its Jacobian, at bends of any size.

In the frame of section 1's bending plane (its azimuth n, across it, z) and with D the angle from there to section 2's
plane, the tip is at

    ( a1 + a2 cos D cos beta1 + b2 sin beta1,  a2 sin D,  b1 - a2 cos D sin beta1 + b2 cos beta1 )

Columns are the derivatives by the bend vectors, along and across each; all are smooth through straight sections.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.two_pair import Pair, Section

_SAFE = 1e-8  # half bend angle below which sin(h)/h is 1 to the last digit


class _Shape(NamedTuple):
    """A section's bend angle, azimuth, and end: to the side, ahead, their slopes, and to the side over bend angle."""

    beta: Array
    nx: Array
    ny: Array
    sine: Array
    cosine: Array
    a: Array
    b: Array
    a_slope: Array
    b_slope: Array
    a_share: Array


class Columns(NamedTuple):
    """Tips and Jacobians of two sections in the frame of section 1's bending plane; rows of shape (n,).

    Attributes:
        first, second: the sections' shapes.
        tip: position in units of length, three rows.
        along1, across1, along2, across2: derivatives by the bends, three rows each.
    """

    first: _Shape
    second: _Shape
    tip: list[Array]
    along1: list[Array]
    across1: list[Array]
    along2: list[Array]
    across2: list[Array]


def _shape(section: Section, bend: Array, straight: float = 0.0, tool: float = 0.0) -> _Shape:
    x, y = bend[..., 0], bend[..., 1]
    beta = np.hypot(x, y)
    off, safe = np.maximum(beta, 1e-300), np.maximum(0.5 * beta, _SAFE)
    h = 0.5 * beta
    sh, ch, r = np.sin(h), np.cos(h), section.chord(h)
    slope, c = section.chord_slope(h, r), np.sin(safe) / safe
    sine, cosine = 2 * sh * ch, ch * ch - sh * sh
    a, b = r * sh, r * ch
    a_slope, b_slope, share = 0.5 * (slope * sh + b), 0.5 * (slope * ch - a), 0.5 * r * c
    if straight or tool:
        a, b = a + tool * sine, b + straight + tool * cosine
        a_slope, b_slope, share = a_slope + tool * cosine, b_slope - tool * sine, share + tool * c * ch
    return _Shape(beta, np.where(beta > 0, x / off, 1.0), y / off, sine, cosine, a, b, a_slope, b_slope, share)


def columns(pair: Pair, bends: Array) -> Columns:
    """Return tips and Jacobians at bends [rad], shape (n, 2, 2)."""
    one, two = _shape(pair.first, bends[:, 0]), _shape(pair.second, bends[:, 1], pair.gap, pair.tool)
    cos_d, sin_d = one.nx * two.nx + one.ny * two.ny, one.nx * two.ny - one.ny * two.nx
    s, c = one.sine, one.cosine
    lateral, across = two.a * cos_d, two.a * sin_d
    tip = [one.a + lateral * c + two.b * s, across, one.b - lateral * s + two.b * c]
    half, safe = 0.5 * one.beta, np.maximum(0.5 * one.beta, _SAFE)
    sinc = np.sin(safe) / safe
    turn, rise = sinc * np.cos(half), sinc * np.sin(half)  # sin(beta1)/beta1, (1 - cos beta1)/beta1
    leaning = two.a_slope * cos_d
    return Columns(
        one, two, tip,
        [one.a_slope + tip[2] - one.b, np.zeros_like(s), one.b_slope - tip[0] + one.a],
        [-across * rise, one.a_share - lateral * rise + two.b * turn, -across * turn],
        [leaning * c + two.b_slope * s, two.a_slope * sin_d, two.b_slope * c - leaning * s],
        [-two.a_share * sin_d * c, two.a_share * cos_d, two.a_share * sin_d * s],
    )  # fmt: skip


def tips(pair: Pair, bends: Array) -> Array:
    """Return tip positions in units of length, shape (n, 3), of bends [rad], shape (n, 2, 2)."""
    at = columns(pair, bends)
    return in_base(at, *at.tip)


def tip_axis(bends: Array) -> Array:
    """Return the direction of the tip's z axis in the base frame, shape (..., 3), of bends [rad], (..., 2, 2)."""
    half = 0.5 * np.hypot(bends[..., 0], bends[..., 1])
    safe = np.maximum(half, _SAFE)
    sine, cosine = np.sin(half), np.cos(half)
    share = (np.sin(safe) / safe * cosine)[..., None] * bends  # sin(beta) along the bend
    axis = 1 - 2 * sine * sine
    # section 1 turns by beta1 in its plane: v -> v + sin(..) .. with the part of v along the bend
    x, y = bends[..., 0, 0], bends[..., 0, 1]
    fall = 0.5 * (np.sin(safe[..., 0]) / safe[..., 0]) ** 2  # (1 - cos beta1)/beta1^2
    along = x * share[..., 1, 0] + y * share[..., 1, 1]
    out = np.empty((*bends.shape[:-2], 3))
    out[..., 0] = share[..., 1, 0] - fall * along * x + share[..., 0, 0] * axis[..., 1]
    out[..., 1] = share[..., 1, 1] - fall * along * y + share[..., 0, 1] * axis[..., 1]
    turn = np.sin(safe[..., 0]) / safe[..., 0] * cosine[..., 0]
    out[..., 2] = axis[..., 0] * axis[..., 1] - turn * along
    return out


def in_base(at: Columns, along: Array, across: Array, z: Array) -> Array:
    """Return vectors, given in the frame of section 1's bending plane, in the base frame, shape (n, 3)."""
    nx, ny = at.first.nx, at.first.ny
    return np.stack([along * nx - across * ny, along * ny + across * nx, z], axis=-1)

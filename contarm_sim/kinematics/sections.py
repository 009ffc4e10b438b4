"""Several sections in a row: pose of the tip, or of any place along the backbone, and the geometric Jacobian.

Bends of S sections are an array of shape (..., S, 2), each in the frame at the section's own base; no section twists,
so the frame at the end of one is the base of the next, moved along its connector. Every formula is a product of those
of `arc`, hence smooth through straight sections.

A chain of N ball joints, all bent alike, passes at its stations through points of the arc scaled by x cot x,
x = |bend|/(2 N), see `chain`; between two stations it is straight.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array, as_xi, sinc, sinc_and_slope
from contarm_sim.kinematics.backbone import Backbone, as_bends


def transform(bends: Any, backbone: Backbone, xi: Any = 1.0, *, check: bool = True) -> Array:
    """Return frames in the base frame, shape (..., 4, 4).

    Args:
        bends: of the sections [rad], shape (..., S, 2).
        xi: places, normalised arc length of the whole backbone (connectors count), from 0 (base) to 1 (tip); broadcasts
            against the leading axes of `bends`.

    Raises:
        InputError: bends or places that cannot be, unless `check` is False.
    """
    bends, xi = _given(bends, backbone, xi, check)
    start, place = 0.0, _place(backbone, xi)
    out = np.broadcast_to(np.eye(4), (*np.broadcast_shapes(bends.shape[:-2], xi.shape), 4, 4))
    for number in range(len(backbone)):
        out = out @ _part(bends[..., number, :], backbone, number, place - start)
        start += backbone.lengths[number] + backbone.connectors[number]
    return np.array(out)


def position(bends: Any, backbone: Backbone, xi: Any = 1.0, *, check: bool = True) -> Array:
    """Return places in the base frame [m], shape (..., 3); arguments as of `transform`."""
    return transform(bends, backbone, xi, check=check)[..., :3, 3]


def frames(bends: Any, backbone: Backbone) -> Array:
    """Return the frames at the base and at the end of each section (before its connector), shape (..., S + 1, 4, 4)."""
    bends = as_bends(bends, backbone)
    frame = np.broadcast_to(np.eye(4), (*bends.shape[:-2], 4, 4))
    out = [frame]
    for number in range(len(backbone)):
        out.append(frame @ _part(bends[..., number, :], backbone, number, np.asarray(backbone.lengths[number])))
        frame = frame @ _part(bends[..., number, :], backbone, number, np.asarray(np.inf))
    return np.stack(out, axis=-3)


def jacobian(bends: Any, backbone: Backbone, xi: Any = 1.0, *, check: bool = True) -> Array:
    """Return the geometric Jacobian in the base frame, shape (..., 6, 2 S): velocity [m/rad], then turning [rad/rad].

    Columns are bend x and y of section 1, of section 2, and so on; arguments as of `transform`.
    """
    bends, xi = _given(bends, backbone, xi, check)
    shape = np.broadcast_shapes(bends.shape[:-2], xi.shape)
    frame, start, place, own = np.broadcast_to(np.eye(4), (*shape, 4, 4)), 0.0, _place(backbone, xi), []
    for number in range(len(backbone)):
        bend = bends[..., number, :]
        part = _part(bend, backbone, number, place - start)
        moves, turns = _part_jacobian(bend, backbone, number, place - start)
        R = frame[..., :3, :3]
        frame = frame @ part
        own.append((R @ moves, R @ turns, frame[..., :3, 3]))
        start += backbone.lengths[number] + backbone.connectors[number]
    out = np.empty((*shape, 6, 2 * len(backbone)))
    for number, (moves, turns, end) in enumerate(own):
        lever = frame[..., :3, 3] - end
        out[..., :3, 2 * number : 2 * number + 2] = moves + _cross(turns, lever)
        out[..., 3:, 2 * number : 2 * number + 2] = turns
    return out


def turning(bend: Any) -> Array:
    """Return what an arc's end turns by as its bend changes, in its base frame [rad/rad], shape (..., 3, 2).

    The arc turns its end by the rotation vector w = (-bend_y, bend_x, 0); columns are the left Jacobian of w,
    A I + B w^ + C w w^T, applied to dw, with A = sin a/a, B = (1 - cos a)/a^2, C = (1 - A)/a^2, a = |w|.
    """
    bend = np.asarray(bend, dtype=float)
    x, y = bend[..., 0], bend[..., 1]
    square = 0.25 * (x * x + y * y)
    c, g = sinc_and_slope(square)
    half, full = 0.5 * c * c, c * (c + square * g)
    # (1 - sin a/a)/a^2: with s = sin(a/2)/(a/2), 1 - s cos(a/2) = (1 - s^2) - (a/2)^2 s g, and 1 - s^2 by the series
    rest = 0.25 * (_square_short(square) - c * g)
    out = np.empty((*bend.shape[:-1], 3, 2))
    out[..., 0, 0], out[..., 0, 1] = -rest * x * y, -(full + rest * y * y)
    out[..., 1, 0], out[..., 1, 1] = full + rest * x * x, rest * x * y
    out[..., 2, 0], out[..., 2, 1] = half * -y, half * x
    return out


def _square_short(y: Array) -> Array:
    """Return (1 - sinc(x)^2)/x^2 of y = x^2, to rounding: 1 - sinc^2 = (1 - sinc)(1 + sinc)."""
    c, _ = sinc_and_slope(np.asarray(y))
    return np.asarray(_short(np.asarray(y)) * (1 + c))


def _short(y: Array) -> Array:
    """Return (1 - sinc(x))/x^2 of y = x^2."""
    series = 1 / 6 - y * (1 / 120 - y * (1 / 5040 - y * (1 / 362880 - y * (1 / 39916800 - y / 6227020800))))
    x = np.sqrt(y)
    return np.where(y < 0.5, series, (1 - sinc(x)) / np.where(y < 0.5, 1.0, y))


def _given(bends: Any, backbone: Backbone, xi: Any, check: bool) -> tuple[Array, Array]:
    if check:
        return as_bends(bends, backbone), as_xi(xi)
    return np.asarray(bends, dtype=float), np.asarray(xi, dtype=float)


def _place(backbone: Backbone, xi: Array) -> Array:
    """Return the arc length [m] of places from the base; the tip is the end, whatever rounding says of a sum."""
    return np.where(xi >= 1, np.inf, xi * backbone.length)


def _part(bend: Array, backbone: Backbone, number: int, beyond: Array) -> Array:
    """Return how a section and its connector move a frame, up to a distance [m] from the section's base."""
    length, share, straight = _along(backbone, number, beyond)
    out = arc.transform(bend, length, share, check=False)
    if backbone.links is not None:
        out[..., :3, 3] *= _shrunk(bend, backbone.links[number])[0][..., None]
    if np.any(straight):
        out[..., :3, 3] += straight[..., None] * out[..., :3, 2]
    return out


def _part_jacobian(bend: Array, backbone: Backbone, number: int, beyond: Array) -> tuple[Array, Array]:
    """Return how the end of `_part` moves and turns by the bend, in the section's base frame, shapes (..., 3, 2)."""
    length, share, straight = _along(backbone, number, beyond)
    moves = arc.jacobian(bend, length, share, check=False)
    share = share[..., None]
    turns = share[..., None] * turning(share * bend)
    if backbone.links is not None:
        scale, slope = _shrunk(bend, backbone.links[number])
        ends = arc.position(bend, length, share[..., 0], check=False)
        moves = scale[..., None, None] * moves + ends[..., :, None] * slope[..., None, :]
    if np.any(straight):
        axis = arc.rotation(bend, share[..., 0], check=False)[..., :, 2]
        moves = moves + _cross(turns, straight[..., None] * axis)
    return moves, turns


def _along(backbone: Backbone, number: int, beyond: Array) -> tuple[float, Array, Array]:
    """Return the section's length [m], the share of its arc that is passed, and the straight length that follows."""
    length = backbone.lengths[number]
    inside = np.clip(beyond, 0.0, length)
    straight = np.clip(beyond - length, 0.0, backbone.connectors[number])
    if backbone.links is None:
        return length, np.asarray(inside / length), straight
    links = backbone.links[number]
    station = np.rint(inside / length * links)
    return length, np.asarray(station / links), straight + (inside - station * (length / links))


def _shrunk(bend: Array, links: int) -> tuple[Array, Array]:
    """Return x cot x, shape (...), and its derivative by the bend [1/rad], shape (..., 2); x = |bend|/(2 links)."""
    y = (bend[..., 0] ** 2 + bend[..., 1] ** 2) / (4 * links**2)
    c, g = sinc_and_slope(y)
    cosine = c + y * g
    slope = -0.5 * (1 + cosine * g / (c * c))
    return cosine / c, (slope / (2 * links**2))[..., None] * bend


def _cross(turns: Array, lever: Array) -> Array:
    """Return turns x lever, shape (..., 3, 2), of turning by columns (..., 3, 2) and levers (..., 3)."""
    return np.cross(turns, lever[..., :, None], axis=-2)

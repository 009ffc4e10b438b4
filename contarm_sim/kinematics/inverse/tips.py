"""Tip frames and Jacobians of many arms at once, as the iterations of inverse kinematics need them: lean, unchecked.

All sections of all arms are evaluated together, in their own base frames; what remains is one product of a 3 x 3 and
a 3 x 8 matrix a section. `sections` says the same at any place along the backbone, and checks what it is given.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array, sinc_and_slope
from contarm_sim.kinematics.backbone import Backbone


def tips_and_jacobians(bends: Array, backbone: Backbone) -> tuple[Array, Array, Array]:
    """Return tip positions [m], shape (n, 3), rotations, shape (n, 3, 3), and geometric Jacobians, shape (n, 6, 2 S).

    Args:
        bends: of the sections [rad], shape (n, S, 2), not checked.
    """
    count, size = bends.shape[:2]
    parts = section_parts(bends, backbone)
    position, rotation = parts[:, 0, :, 4].copy(), parts[:, 0, :, 5:]
    ends = np.empty((count, 3, size))
    ends[:, :, 0] = position
    columns = np.empty((count, 6, size, 2))
    columns[:, :3, 0], columns[:, 3:, 0] = parts[:, 0, :, :2], parts[:, 0, :, 2:4]
    for k in range(1, size):
        turned = rotation @ parts[:, k]
        columns[:, :3, k], columns[:, 3:, k] = turned[:, :, :2], turned[:, :, 2:4]
        position += turned[:, :, 4]
        ends[:, :, k] = position
        rotation = turned[:, :, 5:]
    lever = (position[:, :, None] - ends)[..., None]
    turns = columns[:, 3:]
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        columns[:, a] += turns[:, b] * lever[:, c] - turns[:, c] * lever[:, b]
    return position, rotation, columns.reshape(count, 6, 2 * size)


def tip_axes(bends: Array) -> Array:
    """Return the directions of tips' z axes in the base frame, shape (..., 3), of bends [rad], (..., S, 2)."""
    y = 0.25 * (bends * bends).sum(axis=-1)
    c, g = sinc_and_slope(y)
    cosine = c + y * g
    half, full = 0.5 * c * c, c * cosine
    out = np.empty((*bends.shape[:-2], 3))
    out[..., :2], out[..., 2] = full[..., -1:] * bends[..., -1, :], 1 - 4 * half[..., -1] * y[..., -1]
    for k in range(bends.shape[-2] - 2, -1, -1):
        along = (bends[..., k, :] * out[..., :2]).sum(axis=-1)
        z = out[..., 2].copy()
        out[..., :2] += (full[..., k] * z - half[..., k] * along)[..., None] * bends[..., k, :]
        out[..., 2] = (1 - 4 * half[..., k] * y[..., k]) * z - full[..., k] * along
    return out


def section_parts(bends: Array, backbone: Backbone) -> Array:
    """Return of each section, in its base frame, shape (n, S, 3, 8).

    Columns 0 and 1 are how its end (its connector's end) moves by its bend [m/rad], 2 and 3 how it turns, 4 is the end
    [m], 5 to 7 its rotation. Formulas as of `arc` and `sections.turning`.
    """
    bx, by = bends[..., 0], bends[..., 1]
    length, straight = np.array(backbone.lengths), np.array(backbone.connectors)
    y = 0.25 * (bx * bx + by * by)
    c, g = sinc_and_slope(y)
    square = c * c
    cosine = c + y * g
    half, full = 0.5 * square, c * cosine
    rest = _rest(y, c, g)
    xx, xy, yy = bx * bx, bx * by, by * by
    out = np.empty((*bends.shape[:2], 3, 8))
    out[..., 0, 2], out[..., 0, 3] = -rest * xy, -(full + rest * yy)
    out[..., 1, 2], out[..., 1, 3] = full + rest * xx, rest * xy
    out[..., 2, 2], out[..., 2, 3] = -half * by, half * bx
    out[..., 0, 5], out[..., 0, 6], out[..., 0, 7] = 1 - half * xx, -half * xy, full * bx
    out[..., 1, 5], out[..., 1, 6], out[..., 1, 7] = -half * xy, 1 - half * yy, full * by
    out[..., 2, 5], out[..., 2, 6], out[..., 2, 7] = -full * bx, -full * by, 1 - half * 4 * y
    lateral, curving, falling = half, 0.25 * c * g, 0.25 * (g * cosine - square)
    ends = np.stack([lateral * bx, lateral * by, full], axis=-1)
    moves = np.empty((*bends.shape[:2], 3, 2))
    moves[..., 0, 0], moves[..., 0, 1] = lateral + curving * xx, curving * xy
    moves[..., 1, 0], moves[..., 1, 1] = curving * xy, lateral + curving * yy
    moves[..., 2, 0], moves[..., 2, 1] = falling * bx, falling * by
    if backbone.links is not None:
        scale, slope = _shrunk(y, np.array(backbone.links))
        moves *= scale[..., None, None]
        moves += ends[..., :, None] * (slope[..., None] * bends)[..., None, :]
        ends *= scale[..., None]
    moves *= length[:, None, None]
    ends *= length[:, None]
    if straight.any():
        axis = straight[:, None] * out[..., 7]
        ends += axis
        moves += np.cross(out[..., 2:4], axis[..., None], axis=-2)
    out[..., :2], out[..., 4] = moves, ends
    return out


def _rest(y: Array, c: Array, g: Array) -> Array:
    """Return (1 - sin a/a)/a^2 of y = (a/2)^2, see `sections.turning`; near 0 by its series."""
    small = np.minimum(y, 0.5)
    series = 1 / 362880 - small * (1 / 39916800 - small / 6227020800)
    series = 1 / 6 - small * (1 / 120 - small * (1 / 5040 - small * series))
    short = np.where(y < 0.5, series, (1 - c) / np.maximum(y, 0.5))
    return np.asarray(0.25 * (short * (1 + c) - c * g))


def _shrunk(y: Array, links: Array) -> tuple[Array, Array]:
    """Return x cot x, and its derivative by the bend over the bend; x = |bend|/(2 links), y = (|bend|/2)^2."""
    z = y / links**2
    c, g = sinc_and_slope(z)
    cosine = c + z * g
    return cosine / c, -0.5 * (1 + cosine * g / (c * c)) / (2 * links**2)

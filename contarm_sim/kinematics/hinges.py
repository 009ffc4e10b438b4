"""The chain whose joints are pairs of hinges, every pair turned alike: the shape that parallel muscles hold.

A joint of two hinges is no ball joint: turned by a about x and b about y it bends by a (1 - b^2/12) and b (1 - a^2/12)
and twists by a b/2, to third order. The hinges' order runs xy, yx, yx, xy along the chain, so that the twists cancel;
the bend that is lost is made up for by turning hinges a little more: `angles`. What is left is of third order in the
pitch, and known: `frames` multiplies the joints out.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array, as_vectors

ORDER = ("xy", "yx", "yx", "xy")
"""Axes of joints 1, 2, 3, 4, and so on again; the hinge nearer to the base first."""


AXES = {2: ORDER, 3: ("xyz", "zyx", "zyx", "xyz")}
"""The same by the hinges of a joint: three where the backbone twists."""


def angles(bend: Any, links: int) -> tuple[Array, Array]:
    """Return the sums of hinge angles about y and -x [rad], shape (..., 2), that bend a chain by `bend` [rad].

    And their derivative by the bend, shape (..., 2, 2).
    """
    bend = as_vectors(bend, 2, "bend")
    x, y = bend[..., 0] / links, bend[..., 1] / links
    more = np.stack([1 + y * y / 12, 1 + x * x / 12], axis=-1)
    slope = np.empty((*bend.shape, 2))
    slope[..., 0, 0], slope[..., 1, 1] = more[..., 0], more[..., 1]
    slope[..., 0, 1] = slope[..., 1, 0] = x * y / 6
    return bend * more, slope


def bend_from_angles(total: Array, links: int) -> Array:
    """Return the bend [rad], shape (..., 2), of sums of hinge angles [rad], shape (..., 2): the inverse of `angles`."""
    bend = total
    for _ in range(40):  # each leaves a sixth of the joint angle squared
        share = bend / links
        bend, before = total / (1 + share[..., ::-1] ** 2 / 12), bend
        if np.abs(bend - before).max(initial=0.0) < 1e-15:
            break
    return bend


def frames(bend: Any, length: float, links: int) -> Array:
    """Return frames of base, links and tip [m], shape (..., links + 1, 4, 4), at bends [rad], shape (..., 2)."""
    bend = as_vectors(bend, 2, "bend")
    share = angles(bend, links)[0] / links
    by_axis = {"x": -share[..., 1], "y": share[..., 0]}
    turns = {axis: (np.cos(angle)[..., None], np.sin(angle)[..., None]) for axis, angle in by_axis.items()}
    half = 0.5 * length / links
    out = np.zeros((*bend.shape[:-1], links + 1, 4, 4))
    out[..., 3, 3] = 1.0
    x, y, z = np.broadcast_to(np.eye(3)[:, *[None] * (bend.ndim - 1)], (3, *bend.shape[:-1], 3))
    origin = np.zeros((*bend.shape[:-1], 3))
    for i in range(links + 1):
        if i:
            origin = origin + half * z
            for axis in ORDER[(i - 1) % 4]:
                cos, sin = turns[axis]
                if axis == "x":
                    y, z = cos * y + sin * z, cos * z - sin * y
                else:
                    z, x = cos * z + sin * x, cos * x - sin * z
            origin = origin + half * z
        for column, vector in enumerate((x, y, z, origin)):
            out[..., i, :3, column] = vector
    return out


def chain_frame(angles: Any, pitch: float) -> Array:
    """Return the frame at the end of a chain, shape (..., 4, 4), of its hinges' angles [rad], shape (..., N, 2 or 3).

    Angles stand in the order of the hinges, see `ORDER`; three are x, y and z, each inside out where that begins by y.

    Args:
        pitch: distance of its joints [m]; a half link is at each end.
    """
    angles = np.asarray(angles, dtype=float)
    lead, (count, hinges) = angles.shape[:-2], angles.shape[-2:]
    axes = AXES[hinges]
    origin = np.zeros((*lead, 3))
    x, y, z = np.broadcast_to(np.eye(3)[:, *[None] * len(lead)], (3, *lead, 3))
    for i in range(count):
        origin = origin + 0.5 * pitch * z
        for number, axis in enumerate(axes[i % 4]):
            angle = angles[..., i, number, None]
            cos, sin = np.cos(angle), np.sin(angle)
            if axis == "x":
                y, z = cos * y + sin * z, cos * z - sin * y
            elif axis == "y":
                z, x = cos * z + sin * x, cos * x - sin * z
            else:
                x, y = cos * x + sin * y, cos * y - sin * x
        origin = origin + 0.5 * pitch * z
    out = np.zeros((*lead, 4, 4))
    out[..., 3, 3] = 1.0
    for column, vector in enumerate((x, y, z, origin)):
        out[..., :3, column] = vector
    return out


def tip(bend: Any, length: float, links: int) -> Array:
    """Return tip positions [m], shape (..., 3)."""
    return frames(bend, length, links)[..., -1, :3, 3]

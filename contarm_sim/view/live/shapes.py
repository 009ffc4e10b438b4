"""Meshes that the page draws, and how they are turned. A library for them would take half a second to load."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array

SIDES = 20


def cylinder() -> tuple[Array, Array]:
    """Return vertices and triangles of an upright closed cylinder of radius and height 1 about the origin.

    Rims have vertices of their own for the side and for the lids, so that the edge between them is sharp.
    """
    rings = np.stack([_ring(1.0) + np.array([0, 0, height]) for height in (-0.5, 0.5)])
    index = np.arange(2 * SIDES).reshape(2, SIDES)
    side = faces(np.hstack([index, index[:, :1]]).T)
    fan = np.arange(1, SIDES - 1)
    lid = np.stack([np.zeros_like(fan), fan, fan + 1], axis=1)
    lids = [lid[:, ::-1] + 2 * SIDES, lid + 3 * SIDES]
    return np.concatenate([*rings, *rings]), np.concatenate([side, *lids])


def arrow() -> tuple[Array, Array]:
    """Return vertices and triangles of an arrow from the origin along +Z, 1 long, whose head has a radius of 1."""
    outline = [(0.0, 0.0), (0.4, 0.0), (0.4, 0.0), (0.4, 0.7), (0.4, 0.7), (1.0, 0.7), (1.0, 0.7), (0.0, 1.0)]
    rings = np.stack([_ring(1.0) * radius + np.array([0, 0, height]) for radius, height in outline])
    index = np.arange(len(outline) * SIDES).reshape(len(outline), SIDES)
    closed = np.hstack([index, index[:, :1]])
    parts = [faces(closed[start : start + 2].T) for start in range(0, len(outline), 2)]
    return rings.reshape(-1, 3), np.concatenate(parts)


def hoop(radius: float, thickness: float) -> tuple[Array, Array]:
    """Return vertices and triangles of a ring about +Z, of a radius and with a round rod of a thickness [m]."""
    around = np.linspace(0.0, 2 * np.pi, 49)
    rod = np.linspace(0.0, 2 * np.pi, 11)
    out = radius + 0.5 * thickness * np.cos(rod)
    height = np.broadcast_to(0.5 * thickness * np.sin(rod), (len(around), len(rod)))
    vertices = np.stack([np.outer(np.cos(around), out), np.outer(np.sin(around), out), height], axis=-1)
    return vertices.reshape(-1, 3), faces(np.arange(height.size).reshape(height.shape))


def tube(points: Array, frames: Array, radius: float) -> tuple[Array, Array]:
    """Return vertices and triangles of an open tube along points [m], shape (T, 3), with frames, shape (T, 3, 3)."""
    rims = points[:, None] + _ring(radius) @ frames.swapaxes(1, 2)
    index = np.arange(rims[..., 0].size).reshape(rims.shape[:2])
    return rims.reshape(-1, 3), faces(np.hstack([index, index[:, :1]]).T)


def _ring(radius: float) -> Array:
    turn = np.linspace(0.0, 2 * np.pi, SIDES, endpoint=False)
    return radius * np.stack([np.cos(turn), np.sin(turn), np.zeros(SIDES)], axis=1)


def faces(index: Any) -> Array:
    """Return the triangles, shape (F, 3), between vertices whose numbers lie in a grid, shape (T, K)."""
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    return np.concatenate([np.stack(side, -1).reshape(-1, 3) for side in ((a, b, c), (a, c, d))])


def from_upright(directions: Array) -> Array:
    """Return the quaternions w x y z, shape (T, 4), of the smallest turns from +Z to directions, shape (T, 3)."""
    x, y, z = (directions / np.linalg.norm(directions, axis=1, keepdims=True)).T
    quaternions = np.stack([1 + z, -y, x, np.zeros_like(z)], axis=1)
    quaternions[1 + z < 1e-9] = [0.0, 1.0, 0.0, 0.0]
    return quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)


def as_bytes(colour: Any) -> tuple[int, int, int]:
    """Return red, green and blue, 0 to 255, of a colour of parts from 0 to 1."""
    red, green, blue = (round(255 * float(part)) for part in tuple(colour)[:3])
    return red, green, blue


def linear(colour: Any) -> Any:
    """Return colours from 0 to 1 as viser wants them of parts of one mesh and of lines: without the screen's gamma."""
    given = np.asarray(colour, dtype=float)
    return np.where(given <= 0.04045, given / 12.92, ((given + 0.055) / 1.055) ** 2.4)

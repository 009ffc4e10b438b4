"""What objects look like as triangles, for whoever draws or frames them: in an object's own frame."""

from __future__ import annotations

import mujoco
import numpy as np

from contarm_sim.mjcf.meshes import Triangles, mesh_surface
from contarm_sim.model.objects import Object

_SIDES, _RINGS = 32, 8
"""Sides of what is round, and rings of a half ball."""


def surface(each: Object) -> Triangles:
    """Return the surface of an object that has an end, in its own frame.

    Raises:
        OSError, ValueError: a mesh that cannot be read.
    """
    if each.file is not None:
        return mesh_surface(each.file, each.scale)
    if each.size is not None:
        return _box(np.array(each.size))
    radius, half = each.radius or 0.0, 0.5 * (each.length or 0.0)
    if each.shape == "cylinder":
        return _revolved([(0.0, -half), (radius, -half), (radius, half), (0.0, half)])
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2 * _RINGS + 1)
    turn = np.concatenate([turn[: _RINGS + 1], turn[_RINGS:]]) if half else turn
    ends = np.concatenate([np.full(_RINGS + 1, -half), np.full(len(turn) - _RINGS - 1, half)])
    return _revolved(list(zip(radius * np.cos(turn), radius * np.sin(turn) + ends, strict=True)))


def cap(radius: float) -> Triangles:
    """Return the upper half of a ball of a radius [m] about the origin, open below."""
    turn = np.linspace(0.0, 0.5 * np.pi, _RINGS + 1)
    return _revolved(list(zip(radius * np.cos(turn), radius * np.sin(turn), strict=True)))


def turned(each: Object) -> np.ndarray:
    """Return the rotation of an object's frame into the base's, shape (3, 3)."""
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, np.array(each.quaternion))
    return rotation.reshape(3, 3)


def placed_surface(each: Object) -> np.ndarray:
    """Return the vertices of an object where its world says that it is, base frame [m], shape (K, 3)."""
    return np.asarray(surface(each)[0] @ turned(each).T + each.position)


def _box(size: np.ndarray) -> Triangles:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return 0.5 * size * signs, np.array([part for a, b, c, d in corners for part in ((a, b, c), (a, c, d))])


def _revolved(outline: list[tuple[float, float]]) -> Triangles:
    """Return the surface that an outline of radii and heights, from below, sweeps about +Z."""
    angle = np.linspace(0.0, 2 * np.pi, _SIDES, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(_SIDES)], axis=1)
    vertices = np.concatenate([radius * circle + [0.0, 0.0, height] for radius, height in outline])
    low = (np.arange(len(outline) - 1)[:, None] * _SIDES + np.arange(_SIDES)).reshape(-1)
    beside = low - low % _SIDES + (low + 1) % _SIDES
    a, b, c, d = low, beside, beside + _SIDES, low + _SIDES
    return vertices, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])

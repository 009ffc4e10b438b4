"""What is drawn over the model: lines, balls and glass tubes, which exist in the picture only and cast no shadow."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array

Colour = tuple[float, float, float, float]

MAX_SEGMENTS = 200
"""Segments that a line is drawn with at most: more cost time and show nothing."""

TUBE_SIDES = 18
CLEAR = 0.06
"""Opacity of a tube where it faces the camera, as a fraction of that at its outline."""

_ORIGIN, _UPRIGHT, _UNIT = np.zeros(3), np.eye(3).ravel(), np.ones(3)


def thin(points: Array, limit: int = MAX_SEGMENTS) -> Array:
    """Return every n-th of the points and the last, shape (..., 3), such that at most `limit` segments remain."""
    if len(points) <= limit + 1:
        return points
    stride = -(-(len(points) - 1) // limit)
    kept = points[::stride]
    return kept if (len(points) - 1) % stride == 0 else np.vstack([kept, points[-1]])


def placed(body: Any, points: Array) -> Array:
    """Return points of a body's frame [m], shape (..., 3), as points of the world; `body`: the engine's view of it."""
    return body.xpos + points @ body.xmat.reshape(3, 3).T


def add_line(scene: Any, points: Array, width: float, colour: Colour, colours: Array | None = None) -> None:
    """Draw a line through points of the world [m], shape (T, 3), `width` pixels wide: a fifth of a capsule's time.

    Given `colours`, shape (T - 1, 3), each segment has its own. An opaque line would be drawn once more, brighter, for
    the light that casts shadows.
    """
    import mujoco

    kind = mujoco.mjtGeom.mjGEOM_LINE
    for i, (start, end) in enumerate(pairwise(points)):
        tint = colour[:3] if colours is None else colours[i]
        geom = _add(scene, kind, _UNIT, _ORIGIN, _UPRIGHT, (*tint, min(colour[3], 0.98)))
        mujoco.mjv_connector(geom, kind, width, start, end)


def add_triad(scene: Any, origin: Array, frame: Array, size: float, width: float) -> None:
    """Draw the axes of a frame, shape (3, 3), at a point of the world [m]: x red, y green, z blue, `size` long [m]."""
    for axis, colour in enumerate(((0.86, 0.15, 0.15), (0.10, 0.62, 0.20), (0.15, 0.35, 0.90))):
        add_line(scene, np.stack([origin, origin + size * frame[:, axis]]), width, (*colour, 1.0))


def add_ball(scene: Any, centre: Array, radius: float, colour: Colour) -> None:
    """Draw a ball of a radius [m] about a point of the world [m], shape (3,)."""
    import mujoco

    _add(scene, mujoco.mjtGeom.mjGEOM_SPHERE, np.full(3, radius), centre, _UPRIGHT, colour)


def add_ring(scene: Any, centre: Array, frame: Array, radius: float, width: float, colour: Colour) -> None:
    """Draw a circle of a radius [m] about a point of the world [m], around the z axis of its frame, shape (3, 3)."""
    turn = np.linspace(0.0, 2 * np.pi, TUBE_SIDES + 1)
    rim = radius * np.stack([np.cos(turn), np.sin(turn), np.zeros(TUBE_SIDES + 1)], axis=1)
    add_line(scene, centre + rim @ frame.T, width, colour)


def add_tube(scene: Any, points: Array, frames: Array, radius: float, colour: Colour) -> None:
    """Draw a glass tube along points of the world [m], shape (T, 3), each with its frame, shape (T, 3, 3).

    It is clear in the middle and takes its colour towards its outline, so that what is inside stays visible. Only the
    side that faces the camera is drawn, as triangles: see-through cylinders would show each other's lids.
    """
    import mujoco

    turn = np.linspace(0.0, 2 * np.pi, TUBE_SIDES, endpoint=False)
    outward = np.stack([np.cos(turn), np.sin(turn), np.zeros(TUBE_SIDES)], axis=1) @ frames.swapaxes(1, 2)
    rim = points[:, None] + radius * outward
    a, b, c, d = (_flat(edge) for edge in (rim[:-1], np.roll(rim, -1, 1)[:-1], rim[1:], np.roll(rim, -1, 1)[1:]))
    normal = _unit(np.cross(b - a, c - a))
    facing = np.sum(normal * _unit(np.mean([eye.pos for eye in scene.camera], axis=0) - 0.25 * (a + b + c + d)), axis=1)
    opacity = colour[3] * (CLEAR + (1 - CLEAR) * (1 - facing) ** 2)
    for corner, one, other in ((a, b - a, c - a), (d, c - d, b - d)):
        sides = np.stack([one, other, normal], axis=2).reshape(-1, 9)
        for i in np.flatnonzero(facing > 0):
            tint = (*colour[:3], opacity[i])
            _add(scene, mujoco.mjtGeom.mjGEOM_TRIANGLE, _UNIT, corner[i], sides[i], tint)


def _flat(points: Array) -> Array:
    return points.reshape(-1, 3)


def _unit(vectors: Array) -> Array:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _add(scene: Any, kind: int, size: Array, centre: Array, matrix: Array, colour: Colour) -> Any:
    """Append a geom to the scene and return it."""
    import mujoco

    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, size, centre, matrix, colour)
    geom.category = mujoco.mjtCatBit.mjCAT_DECOR  # casts no shadow
    geom.emission = 0.5
    scene.ngeom += 1
    return geom

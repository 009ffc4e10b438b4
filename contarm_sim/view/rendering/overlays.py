"""What is drawn over the model: lines and balls, which exist in the picture only and cast no shadow."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array

Colour = tuple[float, float, float, float]

MAX_SEGMENTS = 200
"""Segments that a line is drawn with at most: more cost time and show nothing."""

_RING_SIDES = 36

_FIRST = 1e4
"""What lines say is their second size, which they have not: the engine draws glass by distance less largest size."""

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


def add_line(
    scene: Any, points: Array, width: float, colour: Colour, colours: Array | None = None, rank: int = 0
) -> None:
    """Draw a line through points of the world [m], shape (T, 3), `width` pixels wide: a fifth of a capsule's time.

    Given `colours`, shape (T - 1, 3), each segment has its own. Lines of a higher rank cover those of a lower one, and
    all other glass. None is opaque: it would come before all that is not.
    """
    import mujoco

    kind = mujoco.mjtGeom.mjGEOM_LINE
    for i, (start, end) in enumerate(pairwise(points)):
        tint = colour[:3] if colours is None else colours[i]
        geom = _add(scene, kind, _UNIT, _ORIGIN, _UPRIGHT, (*tint, min(colour[3], 0.98)))
        mujoco.mjv_connector(geom, kind, width, start, end)
        geom.size[1] = _FIRST + rank


def add_triad(scene: Any, origin: Array, frame: Array, size: float, width: float) -> None:
    """Draw the axes of a frame, shape (3, 3), at a point of the world [m]: x red, y green, z blue, `size` long [m]."""
    for axis, colour in enumerate(((0.86, 0.15, 0.15), (0.10, 0.62, 0.20), (0.15, 0.35, 0.90))):
        add_line(scene, np.stack([origin, origin + size * frame[:, axis]]), width, (*colour, 1.0))


def add_ball(scene: Any, centre: Array, radius: float, colour: Colour) -> None:
    """Draw a ball of a radius [m] about a point of the world [m], shape (3,)."""
    import mujoco

    _add(scene, mujoco.mjtGeom.mjGEOM_SPHERE, np.full(3, radius), centre, _UPRIGHT, colour)


def add_arrow(scene: Any, start: Array, end: Array, radius: float, colour: Colour) -> None:
    """Draw an arrow of a radius [m] from a point of the world to another [m], shape (3,)."""
    import mujoco

    kind = mujoco.mjtGeom.mjGEOM_ARROW
    geom = _add(scene, kind, _UNIT, _ORIGIN, _UPRIGHT, colour)
    mujoco.mjv_connector(geom, kind, radius, start, end)


def add_disk(scene: Any, centre: Array, frame: Array, radius: float, half: float, colour: Colour) -> None:
    """Draw a disk of a radius and half a thickness [m] about the z axis of its frame, shape (3, 3)."""
    import mujoco

    size = np.array([radius, half, 0.0])
    geom = _add(scene, mujoco.mjtGeom.mjGEOM_CYLINDER, size, centre, np.ascontiguousarray(frame).ravel(), colour)
    geom.emission = 0.15


def add_ring(scene: Any, centre: Array, frame: Array, radius: float, width: float, colour: Colour) -> None:
    """Draw a circle of a radius [m] about a point of the world [m], around the z axis of its frame, shape (3, 3)."""
    turn = np.linspace(0.0, 2 * np.pi, _RING_SIDES + 1)
    rim = radius * np.stack([np.cos(turn), np.sin(turn), np.zeros(_RING_SIDES + 1)], axis=1)
    add_line(scene, centre + rim @ frame.T, width, colour)


def _add(scene: Any, kind: int, size: Array, centre: Array, matrix: Array, colour: Colour) -> Any:
    """Append a geom to the scene and return it."""
    import mujoco

    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, size, centre, matrix, colour)
    geom.category = mujoco.mjtCatBit.mjCAT_DECOR  # casts no shadow
    geom.emission = 0.5
    scene.ngeom += 1
    return geom

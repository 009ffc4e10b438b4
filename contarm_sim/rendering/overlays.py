"""What is drawn over the model: lines, balls and tubes that exist in the picture only."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array

Colour = tuple[float, float, float, float]

MAX_SEGMENTS = 200
"""Segments that a line is drawn with at most: more cost time and show nothing."""


def thin(points: Array, limit: int = MAX_SEGMENTS) -> Array:
    """Return every n-th of the points and the last, shape (..., 3), such that at most `limit` segments remain."""
    if len(points) <= limit + 1:
        return points
    stride = -(-(len(points) - 1) // limit)
    kept = points[::stride]
    return kept if (len(points) - 1) % stride == 0 else np.vstack([kept, points[-1]])


def add_line(scene: Any, points: Array, radius: float, colour: Colour, glow: float = 0.0) -> None:
    """Draw a line through points of the world [m], shape (T, 3), as capsules of a radius [m]."""
    from mujoco import mjtGeom

    for start, end in zip(points[:-1], points[1:], strict=True):
        if not np.array_equal(start, end):
            _connect(scene, mjtGeom.mjGEOM_CAPSULE, radius, start, end, colour, glow)


def add_tube(scene: Any, points: Array, radius: float, colour: Colour) -> None:
    """Draw a see-through tube along points of the world [m], shape (T, 3); open pipes, so that no seams show."""
    from mujoco import mjtGeom

    for start, end in zip(points[:-1], points[1:], strict=True):
        _connect(scene, mjtGeom.mjGEOM_CYLINDER, radius, start, end, colour, 0.0)


def add_ball(scene: Any, centre: Array, radius: float, colour: Colour, glow: float = 0.0) -> None:
    """Draw a ball about a point of the world [m], shape (3,)."""
    import mujoco

    geom = _next(scene)
    mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_SPHERE, np.full(3, radius), centre, np.eye(3).ravel(), colour)
    geom.emission = glow


def _connect(scene: Any, kind: int, radius: float, start: Array, end: Array, colour: Colour, glow: float) -> None:
    import mujoco

    geom = _next(scene)
    mujoco.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), np.eye(3).ravel(), colour)
    mujoco.mjv_connector(geom, kind, radius, start, end)
    geom.emission = glow


def _next(scene: Any) -> Any:
    """Return the scene's next free geom."""
    geom = scene.geoms[scene.ngeom]
    scene.ngeom += 1
    return geom

"""Objects of an arm's world as lines along their edges, for figures in space."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.rotations import rotation_from_quaternion
from contarm_sim.model.objects import Object
from contarm_sim.view.space import Space

_TURN = np.linspace(0, 2 * np.pi, 49)
_RULINGS, _SQUARES = 8, 6


def draw_object(ax: Space, each: Object, extent: float, vertices: Array | None = None) -> None:
    """Draw an object of the base frame: what it covers in its colour, edges in a darker one.

    Args:
        extent: edge of the square that stands for a plane [m].
        vertices: of a mesh, in the base frame [m], shape (V, 3).
    """
    if vertices is not None:
        lines = _hull(vertices)
    else:
        turn = rotation_from_quaternion(each.quaternion)
        lines = [np.array(each.position) + line @ turn.T for line in _EDGES[each.shape](each, extent)]
    dark = tuple(0.6 * part for part in to_rgb(each.colour))
    drawn = [ax.trace(line, color=dark, linewidth=0.5, alpha=0.7, zorder=1.8) for line in lines]
    from scipy.spatial import ConvexHull

    seen = np.concatenate([np.asarray(line.get_xydata()) for line in drawn])
    rim = seen[ConvexHull(seen).vertices]
    ax.fill(*rim.T, facecolor=(*each.colour, 0.4), edgecolor=dark, linewidth=0.8, zorder=1.7)


def _box(each: Object, extent: float) -> list[Array]:
    half = 0.5 * np.array(each.size)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    return [corners[[i, i | bit]] for bit in (1, 2, 4) for i in range(8) if not i & bit]


def _cylinder(each: Object, extent: float) -> list[Array]:
    return _round(each, 0.0)


def _capsule(each: Object, extent: float) -> list[Array]:
    return _round(each, 1.0)


def _round(each: Object, bulge: float) -> list[Array]:
    """Return circles at both ends, and lines along a cylinder that run on over its ends where these bulge."""
    half, radius = 0.5 * (each.length or 0.0), each.radius or 0.0
    circles = [_circle(radius, 0, 1, end) for end in (-half, half)]
    cap = np.linspace(0, np.pi / 2, 9)
    out, up = radius * np.cos(cap), half + bulge * radius * np.sin(cap)
    out, up = np.concatenate([out[::-1], out]), np.concatenate([-up[::-1], up])
    angles = _TURN[:: len(_TURN) // _RULINGS][:_RULINGS]
    if not bulge:
        out, up = np.array([radius, radius]), np.array([-half, half])
    return circles + [np.stack([out * np.cos(a), out * np.sin(a), up], axis=-1) for a in angles]


def _sphere(each: Object, extent: float) -> list[Array]:
    radius = each.radius or 0.0
    tilts = np.linspace(-np.pi / 3, np.pi / 3, 5)
    level = [_circle(radius * float(np.cos(a)), 0, 1, radius * float(np.sin(a))) for a in tilts]
    return [*level, _circle(radius, 0, 2), _circle(radius, 1, 2)]


def _plane(each: Object, extent: float) -> list[Array]:
    marks = np.linspace(-0.5, 0.5, _SQUARES + 1) * extent
    ends = marks[[0, -1]]
    return [np.stack([x, y, 0 * x], axis=-1) for m in marks for x, y in ((ends, m + 0 * ends), (m + 0 * ends, ends))]


def _circle(radius: float, first: int, second: int, aside: float = 0.0) -> Array:
    """Return a circle in the plane of two axes, so far from it along the third [m]."""
    out = np.full((len(_TURN), 3), aside)
    out[:, first], out[:, second] = radius * np.cos(_TURN), radius * np.sin(_TURN)
    return out


def _hull(vertices: Array) -> list[Array]:
    """Return the edges of a convex hull where faces meet at an angle."""
    from scipy.spatial import ConvexHull

    hull, edges = ConvexHull(vertices), []
    for face, (corners, neighbours) in enumerate(zip(hull.simplices, hull.neighbors, strict=True)):
        for k, other in enumerate(neighbours):
            if other > face and hull.equations[face, :3] @ hull.equations[other, :3] < 1 - 1e-6:
                edges.append(vertices[np.delete(corners, k)])
    return edges


_EDGES: dict[str, Callable[[Object, float], list[Any]]] = {
    "box": _box, "cylinder": _cylinder, "capsule": _capsule, "sphere": _sphere, "plane": _plane,
}  # fmt: skip

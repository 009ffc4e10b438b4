"""Distances from points to the surfaces of objects, in closed form: below zero inside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.rotations import rotation_from_quaternion
from contarm_sim.model.objects import Object


@dataclass(frozen=True)
class Hull:
    """A convex hull in the base frame: outward normals of its faces, and their distances from the origin [m]."""

    normals: Array
    offsets: Array

    @classmethod
    def of(cls, vertices: Array) -> Hull:
        """Return the hull of points [m], shape (V, 3)."""
        from scipy.spatial import ConvexHull

        faces = np.unique(ConvexHull(vertices).equations.round(9), axis=0)
        return cls(faces[:, :3], -faces[:, 3])

    def distance(self, points: Array) -> Array:
        """Return how far points (..., 3) are above the highest face [m], shape (...).

        Their distance where a face is nearest, or inside; less than that where an edge or a corner is nearest.
        """
        out = np.full(points.shape[:-1], -np.inf)
        for normal, offset in zip(self.normals, self.offsets, strict=True):
            np.maximum(out, points @ normal - offset, out=out)
        return out


def distance(each: Object, points: Array) -> Array:
    """Return the distances [m], shape (...), of points in the base frame (..., 3) from an object that is no mesh."""
    local = (points - np.array(each.position)) @ rotation_from_quaternion(each.quaternion)
    return _DISTANCES[each.shape](each, local)


def _box(each: Object, p: Array) -> Array:
    return _outside(np.abs(p) - 0.5 * np.array(each.size))


def _sphere(each: Object, p: Array) -> Array:
    return _norm(p) - _number(each.radius)


def _capsule(each: Object, p: Array) -> Array:
    half, away = 0.5 * _number(each.length), p.copy()
    away[..., 2] -= np.clip(p[..., 2], -half, half)
    return _norm(away) - _number(each.radius)


def _cylinder(each: Object, p: Array) -> Array:
    beyond = np.empty((*p.shape[:-1], 2))
    beyond[..., 0] = np.hypot(p[..., 0], p[..., 1]) - _number(each.radius)
    beyond[..., 1] = np.abs(p[..., 2]) - 0.5 * _number(each.length)
    return _outside(beyond)


def _plane(each: Object, p: Array) -> Array:
    return np.asarray(p[..., 2])


def _outside(beyond: Array) -> Array:
    """Return the distance of what lies beyond faces at right angles by so much, shape (..., 2 or 3)."""
    out = _norm(np.maximum(beyond, 0.0))
    out += np.minimum(beyond.max(axis=-1), 0.0)
    return out


def _norm(p: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", p, p)))


def _number(value: Any) -> float:
    assert value is not None  # objects are checked at construction
    return float(value)


_DISTANCES: dict[str, Callable[[Object, Array], Array]] = {
    "box": _box, "sphere": _sphere, "capsule": _capsule, "cylinder": _cylinder, "plane": _plane,
}  # fmt: skip

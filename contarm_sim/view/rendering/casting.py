"""What casts the shadows of objects: balls that fill them, as the floor's soft shadow takes them."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import Object

Balls = tuple[Array, Array, Array]
"""Centres [m], shape (K, 3), radii [m] and the lengths that they stand for [m], shape (K,) each."""

_MOST, _ALL = 24, 400
"""Balls along an edge of an object, and in all of it, at most: few ones show."""


class Casting:
    """The balls of all objects of an arm that have an end."""

    def __init__(self, arm: Arm) -> None:
        self._each = [(one.name, _balls(one)) for one in arm.world.objects if one.shape != "plane"]

    def balls(self, data: Any) -> list[Balls]:
        """Return them where the engine's data have the objects, in the world."""
        found = []
        for name, (points, radii, spans) in self._each:
            body = data.body(name)
            found.append((body.xpos + points @ body.xmat.reshape(3, 3).T, radii, spans))
        return found


def _balls(each: Object) -> Balls:
    """Return balls that fill an object, in its own frame."""
    from contarm_sim.mjcf.surfaces import surface

    vertices = surface(each)[0]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    edges = np.maximum(high - low, 1e-6)
    if each.shape == "sphere":
        edges = 0.85 * edges  # as much light as the ball itself keeps away
    elif each.shape == "mesh":
        edges = 0.7 * edges
    narrow = float(edges.min())
    counts = np.clip(np.rint(edges / narrow).astype(int), 1, _MOST)
    while np.prod(counts) > _ALL:
        counts = np.maximum(counts * 3 // 4, 1)
    places = [middle + width * ((np.arange(count) + 0.5) / count - 0.5)
              for middle, width, count in zip(0.5 * (low + high), edges, counts, strict=True)]  # fmt: skip
    points = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1).reshape(-1, 3)
    size = float(np.prod(edges / counts) ** (1 / 3))
    return points, np.full(len(points), 0.5 * size), np.full(len(points), size)

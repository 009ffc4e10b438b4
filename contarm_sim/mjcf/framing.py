"""Where a camera stands that shows given points as large as the free part of its picture allows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

FOVY = 28.0
"""Vertical field of view of all cameras [deg]."""

_HALVINGS = 40


@dataclass(frozen=True)
class Frame:
    """A picture and what covers it.

    Attributes:
        aspect: width over height.
        top: share of the height that a caption takes.
        cards: shares of width and of height that a plot in each lower corner takes.
        margin: share of width and height that stays free along each edge.
    """

    aspect: float = 1.4
    top: float = 0.07
    cards: tuple[float, float] = (0.0, 0.0)
    margin: float = 0.03


def axes(azimuth: float, elevation: float) -> np.ndarray:
    """Return right, up and backward of a camera at an azimuth and an elevation [deg] as rows, shape (3, 3)."""
    a, e = math.radians(azimuth), math.radians(elevation)
    back = np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])
    right = np.array([-math.sin(a), math.cos(a), 0.0])
    return np.stack([right, np.cross(back, right), back])


def place(points: np.ndarray, radius: float, turn: np.ndarray, frame: Frame) -> np.ndarray:
    """Return the nearest place [m], shape (3,), from which balls about points are seen in a frame's free part.

    A ball at (x, y, z) of the camera's axes is within a share s of the half height if |x - cx| + r <= s (cz - z): at a
    given distance cz the bounds of cx and cy are those of intervals, and nearer is found by halving.

    Args:
        points: centres of the balls [m], shape (T, 3).
        radius: of the balls [m].
        turn: axes of the camera, as `axes` returns them.
    """
    seen = points @ turn.T
    middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
    seen = seen - middle
    near = float(seen[:, 2].max()) + 2 * radius
    far = near + 100 * (float(np.abs(seen).max()) + radius)
    found = _shift(seen, radius, far, frame)
    for _ in range(_HALVINGS):
        depth = 0.5 * (near + far)
        shift = _shift(seen, radius, depth, frame)
        near, far, found = (near, depth, shift) if shift is not None else (depth, far, found)
    sideways = (0.0, 0.0) if found is None else found
    return np.asarray((middle + np.array([*sideways, far])) @ turn)


def _shift(seen: np.ndarray, radius: float, depth: float, frame: Frame) -> tuple[float, float] | None:
    """Return how far to the right and up a camera at a depth must stand, or None if it is too near."""
    slope = math.tan(math.radians(0.5 * FOVY))
    reach = slope * (depth - seen[:, 2])
    wide = frame.aspect * (1 - 2 * frame.margin)
    low, high = 1 - 2 * frame.margin, 1 - 2 * (frame.top + frame.margin)
    left, right = (seen[:, 0] + radius - wide * reach).max(), (seen[:, 0] - radius + wide * reach).min()
    bottom, top = (seen[:, 1] + radius - high * reach).max(), (seen[:, 1] - radius + low * reach).min()
    if left > right or bottom > top:
        return None
    across = 0.5 * (left + right)
    if frame.cards[1]:
        inside = frame.aspect * (1 - 2 * frame.cards[0])
        beside = np.abs(seen[:, 0] - across) + radius > inside * reach
        above = (seen[:, 1] - radius + (1 - 2 * frame.cards[1]) * reach)[beside]
        top = min(top, above.min(initial=math.inf))
        if bottom > top:
            return None
    return across, float(0.5 * (bottom + top))

"""The braid of a pneumatic muscle as a picture that repeats around and along it."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.mckibben import McKibben

NAME = "braid"
_SIZE, _AROUND = 64, 6
"""Side of the picture [pixels], and how many of it go around a muscle."""

_DARKEST, _THREADS = 0.52, 3


@cache
def braid() -> NDArray[np.uint8]:
    """Return one repeat of a plain weave in grey, shape (64, 64, 3): strands of three threads, over one and under one.

    Strands run along u + v and u - v; where both sum to an even cell the one is on top, else the other.
    """
    v, u = (np.mgrid[:_SIZE, :_SIZE] + 0.5) / _SIZE
    one, other = u + v, u - v
    top = (np.floor(one) + np.floor(other)) % 2 == 0
    along, across = np.where(top, one, other) % 1 - 0.5, np.where(top, other, one) % 1 - 0.5
    bulge = np.cos(np.pi * along) * np.sqrt(np.maximum(1 - (2 * across) ** 2, 0.0))
    thread = 0.86 + 0.14 * np.cos(2 * np.pi * _THREADS * across)
    grey = _DARKEST + (1 - _DARKEST) * np.sqrt(bulge) * thread
    return np.repeat((255 * np.clip(grey, 0, 1)).astype(np.uint8)[..., None], 3, axis=2)


def repeats(law: MuscleLaw, rest_length: float) -> tuple[float, float]:
    """Return how often the picture goes around and along a muscle, its strands at the braid's angle to the axis."""
    angle = law.braid_angle if isinstance(law, McKibben) else math.radians(45)
    width = math.pi * law.diameter / _AROUND
    return _AROUND, max(1.0, round(rest_length * math.tan(angle) / width))

"""Lengths of muscles that run straight from guide to guide along the uniformly bent chain, in closed form.

A span from a guide a below a joint to one b above it, at the offset rho from the backbone towards the inside of a
joint bent by beta, has

    s^2 = (a + b)^2 - 4 a b sin^2(beta/2) + (2 rho sin(beta/2))^2 - 2 rho (a + b) sin(beta)

The guides sit g above their link's middle: N - 1 spans with a = h/2 - g, b = h/2 + g, a last one with b = h/2 that
ends in the tip plate, and g along the base, which does not change. For g = h/sqrt(6) spans shorten as they do between
the disks of a rod that bends evenly in between.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array, as_vectors, sinc, sinc_slope
from contarm_sim.kinematics.muscles import PAPER, Angles, bend_of_lengths, directions, towards_muscles

_CORRECTIONS = 30
"""Most steps from lengths to bend, each leaving a few hundredths of the error at 12 links and more."""


@dataclass(frozen=True)
class Guides:
    """Where guides are: backbone length, radius of the attachment circle, height above a link's middle [m]; links;
    angles of the n muscles [rad].

    Attributes:
        root: what runs along the base, below the first guide [m]; default the guides' height. 0 where the muscles come
            from a section before.
        end: height of the guide that the last span ends at, above the section's end [m]; 0 in its end plate.
    """

    length: float
    radius: float
    height: float
    links: int
    angles: Angles = PAPER
    root: float | None = None
    end: float = 0.0

    @property
    def spans(self) -> list[tuple[float, float, float]]:
        """How many spans cross a joint, and from how far below to how far above it they reach [m]."""
        half = 0.5 * self.length / self.links
        return [(self.links - 1, half - self.height, half + self.height), (1, half - self.height, half + self.end)]


def lengths_from_bend(bend: Any, guides: Guides) -> Array:
    """Return muscle lengths [m], shape (..., n), of bends [rad], shape (..., 2)."""
    bend = as_vectors(bend, 2, "bend")
    parts = [count * _span(bend, guides, *ends)[0] for count, *ends in guides.spans]
    return (guides.height if guides.root is None else guides.root) + parts[0] + parts[1]


def length_jacobian(bend: Any, guides: Guides) -> Array:
    """Return dL/dbend [m/rad], shape (..., n, 2)."""
    bend = as_vectors(bend, 2, "bend")
    parts = [count * _span(bend, guides, *ends)[1] for count, *ends in guides.spans]
    return parts[0] + parts[1]


def bend_from_lengths(lengths: Any, guides: Guides) -> tuple[Array, Array]:
    """Return (bend [rad], shape (..., 2); residual [m], shape (...)) of measured muscle lengths [m], shape (..., n).

    Length differences fix the bend; the residual is what their common mode is off by, zero when all joints bend alike.
    """
    lengths = as_vectors(lengths, len(guides.angles), "muscle_lengths")
    bend = bend_of_lengths(lengths, guides.radius, guides.angles)
    for _ in range(_CORRECTIONS):
        off = bend_of_lengths(lengths - lengths_from_bend(bend, guides), guides.radius, guides.angles)
        bend = bend + off
        if np.abs(off).max(initial=0.0) < 1e-14:
            break
    return bend, (lengths - lengths_from_bend(bend, guides)).mean(axis=-1)


def _span(bend: Array, guides: Guides, a: float, b: float) -> tuple[Array, Array]:
    """Return the length of one span of each muscle [m], shape (..., n), and its derivative by the bend [m/rad]."""
    n, reach = guides.links, a + b
    x = np.hypot(bend[..., 0], bend[..., 1])[..., None] / n  # beta
    offset = guides.radius * towards_muscles(bend, guides.angles) / n  # rho beta
    half, full = sinc(0.5 * x), sinc(x)
    across = half**2 * (offset**2 - a * b * x**2)
    squared = reach**2 + across - 2 * reach * offset * full
    span = np.sqrt(squared)
    by_offset = 2 * half**2 * offset - 2 * reach * full
    by_square = 0.25 * half * sinc_slope(0.5 * x) * (offset**2 - a * b * x**2)  # by beta^2
    by_square = by_square - half**2 * a * b - reach * offset * sinc_slope(x)
    slope = by_offset[..., None] * (guides.radius / n * directions(guides.angles))
    slope = slope + by_square[..., None] * (2 / n**2 * bend[..., None, :])
    return span, slope / (2 * span[..., None])

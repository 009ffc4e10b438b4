"""The curve of first chords on which all solutions of a pose of three sections lie, and what follows from its places.

Equations, and what their letters mean, are those of `equation`. Curves, and the chords of a third section in a
plane, are nearly circles: the polynomial of `chord_length` is nearly a line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.kinematics.inverse.three.chord_length import LEAST, ChordLength, horner, horner_slope

Vector = tuple[Array, Array, Array] | Array

ONE_ARC = 1e-13
"""Below this size, over the arm's length, the normal of the circle says nothing: one arc reaches the pose, and with it
a continuum of bends."""

TINY = 1e-300
"""Added to what may be 0 and divides."""


@dataclass(frozen=True)
class Curves:
    """Curves of first chords of n targets; vectors are shape (3, n, 1), in a frame of each curve's own.

    Attributes:
        axes: the frame: the normal of the circle nearest to the curve, the direction on it that is nearest to the
            base's axis, and across both, each in the base frame, shape (3 axes, 3, n).
        target: p [m].
        scalar, vector: Q.
        base, tip: axes that the first section starts along and the last one ends along.
        level: Q0 over the size of the circle's normal, which is of a length [1/m], shape (n, 1).
        extent: the curve is looked at from -extent to extent [rad], shape (n, 1).
        chords: chord lengths of the three sections.
    """

    axes: Array
    target: Array
    scalar: Array
    vector: Array
    base: Array
    tip: Array
    level: Array
    extent: Array
    chords: list[ChordLength]

    def take(self, rows: Index) -> Curves:
        """Return the curves of some targets."""
        vectors = (self.axes[..., rows], self.target[:, rows], self.scalar[rows], self.vector[:, rows],
                   self.base[:, rows], self.tip[:, rows], self.level[rows], self.extent[rows])  # fmt: skip
        return Curves(*vectors, [each.take(rows) for each in self.chords])


def curves(p: Array, Q0: Array, Qv: Array, base: Array, tip: Array, least: Array, lengths: Array,
           chords: list[ChordLength]) -> Curves:  # fmt: skip
    """Return the curves of first chords of targets.

    Args:
        p: positions [m], shape (3, n).
        Q0, Qv: chord products, shapes (n,) and (3, n).
        base, tip: axes, shape (3, n).
        least: least cosine between the first chord and the base's axis, shape (n,).
        lengths: of the first section and of all [m], shape (2, n).
        chords: chord lengths.
    """
    first, size = lengths
    normal = Q0 * (p - chords[0].slope[:, 0] * base) + cross(p, Qv)
    steep = norm(normal)
    void = (
        steep < ONE_ARC * size
    )  # a single arc's pose: any plane through it would do, so take the one through the base
    if void.any():
        sideways = cross(base, Qv)
        sideways[:, norm(sideways) < 1e-7] = np.array([[0.0], [1.0], [0.0]])
        normal, steep = np.where(void, sideways, normal), np.where(void, norm(sideways), steep)
    level = np.where(void, 0.0, Q0 / steep)
    normal = normal / steep
    along = dot(base, normal)
    towards = base - along * normal
    steep = norm(towards)
    alone = steep < 1e-12
    if alone.any():
        other = np.eye(3)[np.argmin(np.abs(normal), axis=0)].T
        towards = np.where(alone, other - dot(other, normal) * normal, towards)
        steep = np.where(alone, norm(towards), steep)
    towards = towards / steep
    # A section cannot bend far where the others, straight, only just bridge what it leaves: sinc(h) < 1 - 0.146 h^2.
    spare = np.maximum(size * (1 + 1e-14) - norm(p), 0.0)
    lowest = np.maximum(least, 1 - 3.42 * spare / first)
    lowest -= 0.02 * (1 - lowest)
    u = np.clip(level * chords[0].start[:, 0], -1.0, 1.0)
    wide = dot(base, towards) * np.sqrt(1 - u * u)
    ratio = np.divide(lowest - along * u, wide, out=np.full_like(u, -1.0), where=wide > 1e-12)
    extent = np.minimum(1.05 * np.arccos(np.clip(ratio, -1.0, 1.0)), np.pi)
    axes = np.stack([normal, towards, cross(normal, towards)])
    turned = [np.einsum("acn,cn->an", axes, each)[..., None] for each in (p, Qv, base, tip)]
    target, vector, base, tip = turned
    return Curves(axes, target, Q0[:, None], vector, base, tip, level[:, None], extent[:, None], chords)


@dataclass(frozen=True)
class Points:
    """Places on curves, and what follows of the first chord alone; arrays broadcast to (n, nodes).

    Attributes:
        first: the first chord's direction w1.
        cosine: between it and the base's axis.
        rest, across: directions of p', and across both m and p'.
        span: |p'| [m].
        normal: m.
        cos_delta, sin_delta: of the angle between w2 and w3.
    """

    first: Vector
    cosine: Array
    rest: Vector
    across: Vector
    span: Array
    normal: Vector
    cos_delta: Array
    sin_delta: Array


def points(on: Curves, t: Array, outside: float = np.nan) -> Points:
    """Return places on curves at angles t [rad], shape (n, nodes); where there are none, NaN, or the nearest if 1.0."""
    cosine, sine = np.cos(t), np.sin(t)
    u, q, c1 = near_circle(on.level, on.base[0], on.base[1] * cosine, on.chords[0], outside)
    w = (u, q * cosine, q * sine)
    rho, Q0, (x, y, z) = on.chords[0](c1), on.scalar, on.vector
    m = (Q0 * w[0] + (y * w[2] - z * w[1]), Q0 * w[1] + (z * w[0] - x * w[2]), Q0 * w[2] + (x * w[1] - y * w[0]))
    sin_delta = norm(m) + TINY
    rest = (on.target[0] - rho * w[0], on.target[1] - rho * w[1], on.target[2] - rho * w[2])
    span = norm(rest) + TINY
    rest = (rest[0] / span, rest[1] / span, rest[2] / span)
    scale = 1 / sin_delta
    across = (
        (m[1] * rest[2] - m[2] * rest[1]) * scale,
        (m[2] * rest[0] - m[0] * rest[2]) * scale,
        (m[0] * rest[1] - m[1] * rest[0]) * scale,
    )
    return Points(w, c1, rest, across, span, m, -dot(on.vector, w), sin_delta)


def near_circle(level: Array, along: Array, towards: Array, chord: ChordLength,
                outside: float) -> tuple[Array, Array, Array]:  # fmt: skip
    """Solve u = level (start + rest(c)), c = along u + towards q, q = sqrt(1 - u^2) >= 0; return u, q and c.

    A step by the rest in short, then one of Newton's method; u is `outside`, with the sign of u, where it passes 1.
    """
    u = level * chord.start
    q, u = _root(u), u + np.zeros_like(towards)
    c = np.maximum(along * u + towards * q, LEAST)
    u = level * (chord.start + horner(chord.low, c))
    np.clip(u, -0.9999999, 0.9999999, out=u)
    q = _root(u)
    c = np.maximum(along * u + towards * q, LEAST)
    off = u - level * (chord.start + horner(chord.rest, c))
    u -= off / (1 - level * horner_slope(chord.low, c) * (along - towards * u / q))
    beyond = np.abs(u) > 1
    u[beyond] = outside * np.sign(u[beyond])
    q = _root(u)
    return u, q, along * u + towards * q


def _root(u: Array) -> Array:
    return np.sqrt(np.maximum(1 - u * u, 0.0))


def dot(a: Vector, b: Vector) -> Array:
    """Return dot products of vectors (3, ...)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def norm(a: Vector) -> Array:
    """Return lengths of vectors (3, ...)."""
    return np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


def cross(a: Array, b: Array) -> Array:
    """Return cross products of vectors (3, ...)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])

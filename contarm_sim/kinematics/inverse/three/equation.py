"""The one scalar equation that is left of three sections and a pose.

A section whose chord points along the unit vector w turns its end by half turns, H(w) H(e3) in the frame of its base.
So three sections reach the position p and the rotation R where, with Q = q k^-1 and q the unit quaternion of R,

    rho1 w1 + rho2 w2 + rho3 w3 = p       and       w3 w2 w1 = Q or -Q   as quaternions, Q = (Q0, Qv),

w1, w2, w3 being the chords' directions in the base frame and rho their lengths (`chord_length`). This leaves

    (Q0 p + p x Qv) . w1 = Q0 rho1                a closed curve of directions w1, nearly a circle: t is the angle on it
    m = Q0 w1 + Qv x w1,  cos delta = -Qv . w1    w2 and w3 lie across m, delta apart, as p' = p - rho1 w1 does
    rho3 sin delta = |p'| sin(delta - beta)       beta, the angle from p' to w3, has two roots, again nearly a circle's
    rho2 = p' . w2 - rho3 cos delta               the scalar equation in t, for each root and for w2 and -w2

The reduction to a curve of first chords and a search along it is known (MICSolver: Qiu and others, RSS 2023).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.three.chord_curve import TINY, Curves, Points, cross, dot, near_circle


@dataclass(frozen=True)
class Roots:
    """Third chords at places on curves, arrays of shape (..., n, nodes); NaN where there are none.

    Attributes:
        cos_beta, sin_beta: of the angle from p' to w3.
        third: cosine between w3 and the tip's axis.
        second: cosine between w2 and the end of section 1.
        projected: p' . w2 - rho3 cos delta [m], which rho2 must be.
        closeness: of the two roots: they merge near 1, and there are none much above; shape (n, nodes).
    """

    cos_beta: Array
    sin_beta: Array
    third: Array
    second: Array
    projected: Array
    closeness: Array


def roots(on: Curves, at: Points, side: Array, outside: float = np.nan) -> Roots:
    """Return the third chords on one side, 1.0 or -1.0; where there are none, NaN, or the nearest if `outside` is 1."""
    chord = on.chords[2]
    d1, d2 = dot(on.tip, at.rest), dot(on.tip, at.across)
    slope = chord.slope * at.sin_delta
    x, y = slope * d1 - at.span * at.sin_delta, slope * d2 + at.span * at.cos_delta
    norm = np.sqrt(x * x + y * y) + TINY
    x, y = x / norm, y / norm
    level = -at.sin_delta / norm
    u, q, c3 = near_circle(level, d1 * x + d2 * y, side * (d2 * x - d1 * y), chord, outside)
    q = side * q
    cos_beta, sin_beta = u * x - q * y, u * y + q * x
    cos_alpha = cos_beta * at.cos_delta + sin_beta * at.sin_delta
    sin_alpha = sin_beta * at.cos_delta - cos_beta * at.sin_delta
    twice = 2 * at.cosine
    e1 = twice * dot(at.first, at.rest) - dot(on.base, at.rest)
    e2 = twice * dot(at.first, at.across) - dot(on.base, at.across)
    projected = at.span * cos_alpha - chord(c3) * at.cos_delta
    return Roots(cos_beta, sin_beta, c3, cos_alpha * e1 + sin_alpha * e2, projected, np.abs(level) * chord.start)


def left(on: Curves, root: Roots, sign: Array) -> Array:
    """Return what the scalar equation leaves [m], for w2 (sign 1.0) or -w2 (-1.0)."""
    return root.projected - sign * on.chords[1](sign * root.second)


def chord_directions(on: Curves, at: Points, root: Roots, sign: Array) -> tuple[Array, Array, Array]:
    """Return the directions of the three chords in the base frame, shape (n, 3) each; one node a curve."""
    rest, across, normal = np.array(at.rest), np.array(at.across), np.array(at.normal)
    w3 = root.cos_beta * rest + root.sin_beta * across
    w2 = sign * (at.cos_delta * w3 + cross(w3, normal))
    w = np.stack([np.array(at.first), w2, w3])[..., 0]
    w = np.einsum("acn,kan->knc", on.axes, w)
    w /= np.sqrt(np.sum(w * w, axis=-1, keepdims=True))
    return w[0], w[1], w[2]

"""Starts near every solution of a pose: sign changes of the scalar equation, seen from both ends of the arm.

A curve of first chords turns back where two third chords merge; there a search along it is blind. The same arm seen
from its tip is another three sections, whose curve turns elsewhere, so that each solution is seen at least once.
Two solutions between neighbouring nodes show as a least value that does not cross zero: a parabola says where. A curve
as small as a node's distance shows as third chords that nearly exist.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.result import Bool, Index
from contarm_sim.kinematics.inverse.three.chord_curve import ONE_ARC, Points, curves, points
from contarm_sim.kinematics.inverse.three.chord_length import ChordLength, chord_lengths
from contarm_sim.kinematics.inverse.three.equation import Roots, chord_directions, left, roots

MARGIN = 0.1
"""By how much a chord's cosine may pass its limit at a node beside a solution."""

_APART = 0.99  # closeness of third chords below which nodes tell them apart

_SIDES = np.array([1.0, -1.0])


def starts(position: Array, rotation: Array, backbone: Backbone, nodes: int) -> tuple[Index, Array]:
    """Return rows of targets, shape (m,), and bends near their solutions [rad], shape (m, 3, 2).

    Args:
        position: of the end of section 3 [m], shape (n, 3).
        rotation: of the end, shape (n, 3, 3).
        backbone: three sections.
        nodes: how many places along each curve are looked at.
    """
    count = len(position)
    Q0, Qv = chord_product(rotation)
    tip = rotation[:, :, 2].T
    base = np.zeros_like(tip)
    base[2] = 1.0
    chords, least, lengths = _both_ways(backbone, count)
    # Seen from the tip: chords in reverse, their product is that of w1 w2 w3.
    p, Q0, Qv, first, last = (
        np.concatenate(pair, axis=-1)
        for pair in ((position.T, position.T), (Q0, -Q0), (Qv.T, Qv.T), (base, tip), (tip, base))
    )
    on = curves(p, Q0, Qv, first, last, least[0], lengths, chords)
    at = points(on, np.linspace(-1.0, 1.0, nodes) * on.extent)
    root = roots(on, at, _SIDES[:, None, None])
    off = left(on, root, _SIDES[:, None, None, None])
    seen = _crossings(off, _inside(at, root, least[..., None])), _islands(at.cosine, root.closeness, least[0, :, None])
    sign, side, row, place = (np.concatenate(each) for each in zip(*seen, strict=True))
    on = on.take(row)
    at = points(on, (2 * place / (nodes - 1) - 1)[:, None] * on.extent, 1.0)
    root = roots(on, at, _SIDES[side][:, None], 1.0)
    w1, w2, w3 = chord_directions(on, at, root, _SIDES[sign][:, None])
    back = (row >= count)[:, None]
    bends = bends_of_chords(np.where(back, w3, w1), w2, np.where(back, w1, w3))
    known = np.isfinite(bends[:, 0, 0])
    return row[known] % count, bends[known]


@lru_cache(maxsize=64)
def _both_ways(backbone: Backbone, count: int) -> tuple[list[ChordLength], Array, Array]:
    """Return chord lengths, least cosines (3, 2 count), and lengths of the first section and of all (2, 2 count) [m].

    Of as many arms, and of as many seen from their tips.
    """
    order = [[k] * count + [2 - k] * count for k in range(3)]
    cosines = np.cos(0.5 * np.asarray(backbone.limits))
    lengths = np.stack([np.asarray(backbone.lengths)[order[0]], np.full(2 * count, sum(backbone.lengths))])
    return chord_lengths(backbone, order), np.stack([cosines[each] for each in order]), lengths


def _inside(at: Points, root: Roots, least: Array) -> Bool:
    """Return where nodes lie within the limits or just beyond; shape (2 signs, 2 sides, n, nodes)."""
    least = least - MARGIN
    inside = (at.cosine > least[0]) & (root.third > least[2])
    return np.stack([inside & (root.second > least[1]), inside & (root.second < -least[1])])


def _crossings(off: Array, inside: Bool) -> tuple[Index, Index, Index, Array]:
    """Return sign, side and row, and the place in units of nodes, of zeros of functions that are known at nodes."""
    crosses = off[..., 1:] * off[..., :-1] <= 0
    crosses &= inside[..., 1:] | inside[..., :-1]
    at = np.nonzero(crosses)
    low, high = off[at], off[(*at[:3], at[3] + 1)]
    share = low / (low - high + (low == high))
    size = np.abs(off)
    least = (size[..., 1:-1] <= size[..., :-2]) & (size[..., 1:-1] <= size[..., 2:]) & inside[..., 1:-1]
    least &= ~(crosses[..., 1:] | crosses[..., :-1])
    near = np.nonzero(least)
    before, here, after = (size[(*near[:3], near[3] + k)] for k in range(3))
    curved, slope = before - 2 * here + after + 1e-300, 0.5 * (after - before)
    vertex, apart = -slope / curved, 2 * here / curved - (slope / curved) ** 2
    few = apart < 0.3
    near, vertex, apart = tuple(each[few] for each in near), vertex[few], np.sqrt(np.abs(apart[few]))
    *which, node = (np.concatenate([a, b, b]) for a, b in zip(at, near, strict=True))
    place = np.concatenate([share, 1 + vertex - apart, 1 + vertex + apart])
    return which[0], which[1], which[2], node + place


def _islands(cosine: Array, closeness: Array, least: Array) -> tuple[Index, Index, Index, Array]:
    """Return sign, side and row, and the place in units of nodes, where third chords exist at few nodes or none."""
    before, here, after = closeness[:, :-2], closeness[:, 1:-1], closeness[:, 2:]
    row, node = np.nonzero((here > _APART) & (here <= before) & (here < after) & (cosine[:, 1:-1] > least - MARGIN))
    before, here, after = before[row, node], here[row, node], after[row, node]
    place = node + 1 + 0.5 * (before - after) / (before - 2 * here + after + 1e-300)
    sign = np.repeat(np.arange(2), len(row))
    return sign, np.zeros_like(sign), np.tile(row, 2), np.tile(place, 2)


def chord_product(rotation: Array) -> tuple[Array, Array]:
    """Return q k^-1, q the unit quaternions of rotations (n, 3, 3): scalar (n,) and vector (n, 3)."""
    R, back = rotation, rotation.swapaxes(-1, -2)
    trace = R[:, 0, 0] + R[:, 1, 1] + R[:, 2, 2]
    K = np.empty((len(R), 4, 4))
    off = R - back
    K[:, 0, 0] = 1 + trace
    K[:, 0, 1], K[:, 0, 2], K[:, 0, 3] = off[:, 2, 1], off[:, 0, 2], off[:, 1, 0]
    K[:, 1:, 0] = K[:, 0, 1:]
    K[:, 1:, 1:] = R + back + (1 - trace)[:, None, None] * np.eye(3)
    # Each row of K is a multiple of q: take the longest.
    best = np.argmax(np.einsum("nii->ni", K), axis=-1)
    q = K[np.arange(len(R)), best]
    q /= np.sqrt(np.sum(q * q, axis=-1, keepdims=True))
    return q[:, 3], np.stack([-q[:, 2], q[:, 1], -q[:, 0]], axis=-1)


def one_arc(position: Array, rotation: Array, backbone: Backbone) -> Bool:
    """Return where one arc, of some length, would reach the poses that `starts` takes, shape (n,)."""
    Q0, (x, y, z) = (part.T for part in chord_product(rotation))
    px, py, pz = position.T / backbone.length
    across = np.maximum(np.maximum(np.abs(py * z - pz * y), np.abs(pz * x - px * z)), np.abs(px * y - py * x))
    return np.asarray(np.maximum(np.abs(Q0), across) < ONE_ARC)


def bends_of_chords(w1: Array, w2: Array, w3: Array) -> Array:
    """Return bends [rad], shape (n, 3, 2), of sections whose chords lie along unit vectors in the base frame."""
    second = _half_turn(w1, w2)
    second[:, :2] *= -1
    chords = np.stack([w1, second, _half_turn(w1, _half_turn(w2, w3))], axis=1)
    across = np.hypot(chords[..., 0], chords[..., 1])
    bend = 2 * np.arctan2(across, chords[..., 2])
    scale = np.divide(bend, across, out=np.full_like(bend, 2.0), where=across > 0)
    return np.asarray(scale[..., None] * chords[..., :2])


def _half_turn(w: Array, v: Array) -> Array:
    return np.asarray(2 * np.sum(w * v, axis=-1, keepdims=True) * w - v)

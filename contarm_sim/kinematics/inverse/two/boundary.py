"""The nearest reachable tip position for targets that two sections do not reach, outside or in the cavity.

The reachable positions are those of a shell of revolution, so the nearest lies in the target's meridian plane. At a
fixed beta1 the bend and azimuth of section 2 move the tip in two directions of the meridian plane unless the pose is
planar: the boundary consists of planar poses (both derivatives parallel, or a bend angle at its limit) and of poses
with both bend angles at their limits. Candidates of all these are tabulated once for a backbone; the nearest of them
are polished, by Newton steps on the squared distance within the limits.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.kinematics.inverse.tips import section_parts, tips_and_jacobians
from contarm_sim.kinematics.inverse.two.equations import as_targets
from contarm_sim.kinematics.inverse.two.pair import Pair
from contarm_sim.kinematics.inverse.two.scalars import crossings, minima

_COUNT = 129  # bend angles of the table
_REACH = 0.03  # distance from one place of the table to the next, in units of length, with room
_APART = 0.15  # bend angle [rad] from which candidates count as two
_STEPS, _DIFFERENCE = 40, 1e-4
_FLAT = 1e-12  # smallest second derivative that a step divides by: at a fold, near the boundary, there is next to none


class _Table(NamedTuple):
    """Candidates: signed bend angles in the meridian plane, the tip's distance from the axis and height, and group."""

    angles: Array
    tip: Array
    group: Index


def nearest_bends(pair: Pair, points: Array) -> Array:
    """Return bends [rad], shape (n, 2, 2), of the reachable positions nearest to points (n, 3) in units of length."""
    targets = as_targets(points)
    target = np.stack([targets.rho, targets.z], axis=-1)
    angles, twist = _planar(pair, target)
    both, distance = _both_limits(pair, target)
    planar = np.linalg.norm(_meridian(pair, angles)[0] - target, axis=-1)
    at_limits = distance < planar
    limits = np.array(pair.limits)
    angles[at_limits], twist[at_limits] = limits, both[at_limits]
    tip = _meridian(pair, angles, twist)[1]
    azimuth = np.arctan2(targets.uy, targets.ux) - np.arctan2(tip[:, 1], tip[:, 0])
    return _bends(angles, twist, azimuth)


def _bends(angles: Array, twist: Array, azimuth: Array) -> Array:
    plane = np.stack([azimuth, azimuth + twist], axis=-1)
    return np.stack([angles * np.cos(plane), angles * np.sin(plane)], axis=-1)


def _meridian(pair: Pair, angles: Array, twist: Array | float = 0.0) -> tuple[Array, Array]:
    """Return the tip's distance from the axis (signed if planar) and height, (n, 2), and position, (n, 3).

    Section 1 bends towards x, section 2 at an azimuth `twist` from there.
    """
    twist = np.broadcast_to(twist, angles.shape[:1])
    tip = tips_and_jacobians(_bends(angles, twist, np.zeros(len(angles))), pair.backbone)[0]
    return np.stack([np.where(tip[:, 1] == 0, tip[:, 0], np.hypot(tip[:, 0], tip[:, 1])), tip[:, 2]], axis=-1), tip


def _slopes(pair: Pair, angles: Array, target: Array) -> tuple[Array, Array, Array]:
    """Return half the squared distance of planar poses, its gradient by the signed angles, and the tip's derivatives.

    Shapes (n,), (n, 2) and (n, 2, 2): coordinates, then angles.
    """
    parts = section_parts(np.stack([angles, np.zeros_like(angles)], axis=-1), pair.backbone)
    (x1, z1, along1), (x2, z2, along2) = ((p[:, 0, 4], p[:, 2, 4], p[:, ::2, 0]) for p in (parts[:, 0], parts[:, 1]))
    s, c = parts[:, 0, 0, 7], parts[:, 0, 2, 7]
    x2, z2 = c * x2 + s * z2, c * z2 - s * x2
    J = np.empty((len(angles), 2, 2))
    J[:, 0, 0], J[:, 1, 0] = along1[:, 0] + z2, along1[:, 1] - x2
    J[:, 0, 1], J[:, 1, 1] = c * along2[:, 0] + s * along2[:, 1], c * along2[:, 1] - s * along2[:, 0]
    off = np.stack([x1 + x2, z1 + z2], axis=-1) - target
    return 0.5 * (off * off).sum(axis=-1), (off[:, :, None] * J).sum(axis=1), J


def _determinant(pair: Pair, angles: Array) -> Array:
    J = _slopes(pair, angles, np.zeros(2))[2]
    return J[:, 0, 0] * J[:, 1, 1] - J[:, 0, 1] * J[:, 1, 0]


def _share(pair: Pair, a: Array, c: Array, sign: Array, fa: Array, fc: Array) -> Array:
    """Return what share of the way from a to c, angles (n, 2), the determinant vanishes at."""

    def determinant(share: Array, index: Index) -> Array:
        return sign[index] * _determinant(pair, a[index] + share[:, None] * (c[index] - a[index]))

    return crossings(determinant, np.zeros(len(a)), np.ones(len(a)), fa - 1e-300, fc, 1e-6)


@lru_cache(maxsize=16)
def _table(pair: Pair) -> _Table:
    one, two = np.linspace(0, pair.limits[0], _COUNT), np.linspace(-pair.limits[1], pair.limits[1], 2 * _COUNT - 1)
    grid = np.stack(np.meshgrid(one, two, indexing="ij"), axis=-1)
    D = _determinant(pair, grid.reshape(-1, 2)).reshape(grid.shape[:2])
    rows = []
    for axis in (0, 1):
        d = np.moveaxis(D, axis, 0)
        places = np.moveaxis(grid, axis, 0)
        change = np.nonzero((d[1:] >= 0) != (d[:-1] >= 0))
        a, c = places[:-1][change], places[1:][change]
        fa, fc = d[:-1][change], d[1:][change]
        sign = np.where(fc >= 0, 1.0, -1.0)
        share = _share(pair, a, c, sign, sign * fa, sign * fc)
        rows.append(a + share[:, None] * (c - a))
    fold = np.concatenate([*rows, [[0.0, 0.0]]])
    parts = [fold[fold[:, 1] >= 0], fold[fold[:, 1] < 0], grid[-1], grid[:, 0], grid[:, -1]]
    angles, group = np.concatenate(parts), np.repeat(np.arange(len(parts)), [len(x) for x in parts])
    tip = _meridian(pair, angles)[0]
    sign = np.where(tip[:, :1] < 0, -1.0, 1.0)
    tip[:, 0] = np.abs(tip[:, 0])
    return _Table(angles * sign, tip, group)


def _planar(pair: Pair, target: Array) -> tuple[Array, Array]:
    """Return signed angles (n, 2) of the planar pose nearest to targets in the meridian plane, and a twist of 0."""
    table = _table(pair)
    square = (target[:, :1] - table.tip[:, 0]) ** 2 + (target[:, 1:] - table.tip[:, 1]) ** 2
    distance = np.sqrt(square)
    closest, owner, start = distance.min(axis=1), [], []
    for group in range(int(table.group.max()) + 1):
        own = np.flatnonzero(table.group == group)
        if not own.size:
            continue
        part = distance[:, own].copy()
        for _ in range(2):
            k = part.argmin(axis=1)
            found = table.angles[own[k]]
            near = np.flatnonzero(part[np.arange(len(part)), k] <= closest + _REACH)
            owner.append(near)
            start.append(found[near])
            part[np.abs(table.angles[own] - found[:, None]).max(axis=-1) < _APART] = np.inf
    rows, angles = np.concatenate(owner), np.concatenate(start)
    value, angles = _descended(pair, angles, target[rows])
    order = np.lexsort((value, rows))
    first = np.searchsorted(rows[order], np.arange(len(target)))
    return angles[order[first]], np.zeros(len(target))


def _descended(pair: Pair, angles: Array, target: Array) -> tuple[Array, Array]:
    """Return half the squared distance and the angles at its minimum within the limits, by Newton steps."""
    limits, angles = np.array(pair.limits), angles.copy()
    value = _slopes(pair, angles, target)[0]
    left, reach = np.arange(len(angles)), np.ones(len(angles))
    for _ in range(_STEPS):
        if not left.size:
            break
        at, to = angles[left], target[left]
        gradient, H = _second(pair, at, to)
        stuck = (np.abs(at) >= limits) & (gradient * at < 0)
        gradient[stuck] = 0.0
        H[:, 0, 1][stuck.any(axis=1)] = 0.0
        a, d, b = np.where(stuck[:, 0], 1.0, H[:, 0, 0]), np.where(stuck[:, 1], 1.0, H[:, 1, 1]), H[:, 0, 1]
        lowest = 0.5 * (a + d - np.hypot(a - d, 2 * b))
        shift = np.where(lowest < _FLAT, _FLAT - 1.5 * lowest, 0.0)
        a, d = a + shift, d + shift
        step = np.stack([d * gradient[:, 0] - b * gradient[:, 1], a * gradient[:, 1] - b * gradient[:, 0]], axis=-1)
        step *= (-reach[left] / (a * d - b * b))[:, None]
        step *= np.minimum(1.0, 0.3 / np.maximum(np.abs(step).max(axis=-1), 1e-300))[:, None]
        new = np.minimum(np.maximum(at + step, -limits), limits)
        f = _slopes(pair, new, to)[0]
        better = f < value[left]
        small = np.abs(new - at).max(axis=-1) < 1e-11
        reach[left] = np.where(better, np.minimum(1.0, 4 * reach[left]), 0.25 * reach[left])
        angles[left[better]], value[left[better]] = new[better], f[better]
        left = left[~small & (reach[left] > 1e-6)]
    return value, angles


def _second(pair: Pair, angles: Array, target: Array) -> tuple[Array, Array]:
    """Return the gradient of half the squared distance, and its second derivatives by differences."""
    off = _DIFFERENCE * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    every = np.concatenate([angles[None], angles + off[:, None]]).reshape(-1, 2)
    g = _slopes(pair, every, np.tile(target, (5, 1)))[1].reshape(5, -1, 2)
    H = np.stack([g[1] - g[2], g[3] - g[4]], axis=1) / (2 * _DIFFERENCE)
    return g[0], 0.5 * (H + H.swapaxes(1, 2))


def _both_limits(pair: Pair, target: Array) -> tuple[Array, Array]:
    """Return the azimuth of section 2 from section 1, both at their limits, that comes nearest, and the distance."""
    limits, twist = np.array(pair.limits), np.linspace(0, np.pi, _COUNT)
    tip = _meridian(pair, np.broadcast_to(limits, (_COUNT, 2)), twist)[0]
    tip[:, 0] = np.abs(tip[:, 0])
    square = (target[:, :1] - tip[:, 0]) ** 2 + (target[:, 1:] - tip[:, 1]) ** 2
    rows, k = np.arange(len(target)), square.argmin(axis=1)
    a, c = np.maximum(k - 1, 0), np.minimum(k + 1, _COUNT - 1)

    def value(x: Array, index: Index) -> Array:
        tip = _meridian(pair, np.broadcast_to(limits, (len(x), 2)), x)[0]
        return (np.abs(tip[:, 0]) - target[index, 0]) ** 2 + (tip[:, 1] - target[index, 1]) ** 2

    best, squared = minima(value, twist[a], twist[k], twist[c], (square[rows, a], square[rows, k], square[rows, c]), 16)
    return best, np.sqrt(squared)

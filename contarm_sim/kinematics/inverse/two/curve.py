"""Bends along the pieces of the family of two sections, and the choices among them.

A piece from `low` to `high` is run through by an angle tau from 0 to pi, beta1 = mean - half width cos(tau): the
elbow's azimuth changes like the root of beta1's distance from a planar end, hence smoothly with tau. Near the axis the
azimuth follows tau itself, because beta1 hardly changes. The mirror branch is +1 or -1, the sign of the azimuth.

By (1), beta2 rises with beta1 all along where z + b2 > 0, and falls where it is below. Where it rises, the low end is
the choice of least total bend, of least largest bend, and farthest from the limits. Where it falls, the last two are
where one bend angle overtakes the other (one distance from the limit the other), and least total bend is looked for.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.result import Bool, Index
from contarm_sim.kinematics.inverse.two.equations import Targets, elbow
from contarm_sim.kinematics.inverse.two.pair import Pair
from contarm_sim.kinematics.inverse.two.pieces import Pieces
from contarm_sim.kinematics.inverse.two.scalars import crossings, minima

ON_AXIS = 1e-9
"""Distance from the axis, in units of the backbone's length, below which every azimuth solves to rounding."""

PLANAR = 1e-10
"""How far (2) may be from a cosine of 1, in units of the backbone's length, at a planar end."""

_NODES = 17  # samples of tau on each branch

Objective = Callable[[Array, Index], Array]
"""What is to be least: of bends (n, ..., 2, 2) of targets by their indices (n,)."""


class Places(NamedTuple):
    """Places on pieces: index of the target, beta1 [rad], cos(tau), branch; shape (n,) each."""

    owner: Index
    beta1: Array
    cosine: Array
    branch: Array


def bends_at(pair: Pair, targets: Targets, beta1: Array, cosine: Array, branch: Array) -> Array:
    """Return bends [rad], shape (..., 2, 2), at feasible beta1, cos(tau) and branch; all broadcast."""
    at = elbow(pair, targets, beta1)
    off = np.maximum(targets.rho * at.sine, 1e-300)
    c = np.where(targets.rho < ON_AXIS, cosine, np.minimum(np.maximum(at.lead / off, -1.0), 1.0))
    s = branch * np.sqrt((1 - c) * (1 + c))
    nx, ny = targets.ux * c - targets.uy * s, targets.uy * c + targets.ux * s
    # what remains from the elbow to the tip, to the sides of section 1's end: in the plane of the bend, and across it
    along = (targets.rho * c - at.a1) * at.cosine - (targets.z - at.b1) * at.sine
    across = -targets.rho * s
    size = np.hypot(along, across)
    scale = 2 * at.half2 / np.maximum(size, 1e-300)
    along, across = np.where(size > 0, along * scale, 2 * at.half2), across * scale
    out = np.empty((*along.shape, 2, 2))
    out[..., 0, 0], out[..., 0, 1] = beta1 * nx, beta1 * ny
    out[..., 1, 0], out[..., 1, 1] = along * nx - across * ny, along * ny + across * nx
    return out


def places(pieces: Pieces, cosine: Array) -> Array:
    """Return beta1 [rad] at cos(tau), of one piece each, or of a column of pieces."""
    low, high = (x.reshape(-1, *[1] * (cosine.ndim - 1)) for x in (pieces.low, pieces.high))
    return 0.5 * ((low + high) - (high - low) * cosine)


def _best(owner: Index, value: Array) -> Index:
    """Return the index of the least value of each owner, by increasing owner."""
    order = np.lexsort((value, owner))
    first = np.ones(len(order), dtype=bool)
    first[1:] = owner[order[1:]] != owner[order[:-1]]
    return order[first]


def least_bends(pair: Pair, targets: Targets, pieces: Pieces, choose: str) -> Places:
    """Return the place of each target that has pieces by a choice on bend angles alone; targets are columns (n,)."""
    of = targets.at(pieces.owner)
    shift = {"least-bend": 0.0, "least-largest": 0.0, "farthest": pair.limits[0] - pair.limits[1]}[choose]
    at = elbow(pair, of, pieces.low)
    beta1, beta2 = pieces.low.copy(), 2 * at.half2
    falls = np.flatnonzero((of.z + pair.far(at.half2)[1] < 0) & (pieces.high > pieces.low))
    if falls.size:
        some, low, high = of.at(falls), pieces.low[falls], pieces.high[falls]

        def total(x: Array, index: Index) -> Array:
            return x + 2 * elbow(pair, some.at(index), x).half2

        def ahead(x: Array, index: Index) -> Array:
            return x - 2 * elbow(pair, some.at(index), x).half2 - shift

        if choose == "least-bend":
            beta1[falls] = _least_total(pair, some, low, high, total)
        else:
            every = np.arange(len(falls))
            f_low, f_high = ahead(low, every), ahead(high, every)
            x = np.where(f_low >= 0, low, high)
            cross = np.flatnonzero((f_low < 0) & (f_high > 0))
            x[cross] = crossings(
                lambda x, i: ahead(x, cross[i]), low[cross], high[cross], f_low[cross], f_high[cross], 1e-12
            )
            beta1[falls] = x
        beta2[falls] = 2 * elbow(pair, some, beta1[falls]).half2
    value = beta1 + beta2 if choose == "least-bend" else np.maximum(beta1, beta2 + shift)
    best = _best(pieces.owner, value)
    middle, half = 0.5 * (pieces.low + pieces.high)[best], 0.5 * (pieces.high - pieces.low)[best]
    cosine = np.minimum(np.maximum((middle - beta1[best]) / np.maximum(half, 1e-300), -1.0), 1.0)
    return Places(pieces.owner[best], beta1[best], cosine, np.ones(len(best)))


def _least_total(pair: Pair, of: Targets, low: Array, high: Array, total: Callable[..., Array]) -> Array:
    """Return where the sum of the bend angles is least on intervals [low, high]."""
    share = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, _NODES))
    x = low[:, None] + (high - low)[:, None] * share
    f = x + 2 * elbow(pair, of.columns(), x).half2
    rows, k = np.arange(len(low)), f.argmin(axis=1)
    a, c = np.maximum(k - 1, 0), np.minimum(k + 1, _NODES - 1)
    return minima(total, x[rows, a], x[rows, k], x[rows, c], (f[rows, a], f[rows, k], f[rows, c]))[0]


def least(pair: Pair, targets: Targets, pieces: Pieces, objective: Objective) -> Places:
    """Return the place of each target that has pieces where an objective is least, on both branches."""
    tau, of = np.linspace(0, np.pi, _NODES), targets.at(pieces.owner)
    cosine, branches = np.cos(tau)[None, None], np.array([1.0, -1.0])[None, :, None]
    wide = Targets(*(t[:, None, None] for t in of))
    f = objective(bends_at(pair, wide, places(pieces, cosine), cosine, branches), pieces.owner)
    ends = planar_ends(pair, of, pieces)
    row, side, k, (before, middle, after) = _lowest(f, ends, pieces.owner, len(targets.z))
    own, some, owner, branch = pieces.at(row), of.at(row), pieces.owner[row], branches[0, side, 0]
    flips = ends[0][row], ends[1][row]

    def at(angle: Array, index: Index) -> tuple[Array, Array, Array]:
        """Return beta1, cos(tau) and branch at angles tau that may lie past planar ends."""
        turned = (flips[0][index] & (angle < 0)) | (flips[1][index] & (angle > np.pi))
        cosine = np.cos(angle)
        return places(own.at(index), cosine), cosine, np.where(turned, -branch[index], branch[index])

    def value(angle: Array, index: Index) -> Array:
        return objective(bends_at(pair, some.at(index), *at(angle, index)), owner[index])

    low, high = tau[k] - np.where(np.isinf(before), 0, tau[1]), tau[k] + np.where(np.isinf(after), 0, tau[1])
    values = np.where(np.isinf(before), middle, before), middle, np.where(np.isinf(after), middle, after)
    angle, reached = minima(value, low, tau[k], high, values)
    best = _best(owner, reached)
    return Places(owner[best], *at(angle[best], best))


Samples = tuple[Index, Index, Index, tuple[Array, Array, Array]]
"""Piece, branch and sample, and the values before, at, and after it."""


def _lowest(f: Array, planar: tuple[Bool, Bool], owner: Index, count: int) -> Samples:
    """Return the samples about which an objective may be least of all, of values f of shape (pieces, 2, samples)."""
    # past a planar end the other branch goes on, a limit is the end
    past = [np.where(end[:, None], f[:, ::-1, k], np.inf)[..., None] for end, k in zip(planar, (1, -2), strict=True)]
    around = np.concatenate([past[0], f, past[1]], axis=-1)
    before, after = around[..., :-2], around[..., 2:]
    lowest = np.full(count, np.inf)
    np.minimum.at(lowest, owner, f.min(axis=(1, 2)))
    # a parabola through three samples goes below the middle one by an eighth of its second difference at most
    drop = np.where(np.isinf(before), after, before) + np.where(np.isinf(after), before, after) - 2 * f
    drop *= 0.25
    row, side, k = at = np.nonzero((f <= before) & (f <= after) & (f - drop <= lowest[owner][:, None, None]))
    return row, side, k, (before[at], f[at], after[at])


def planar_ends(pair: Pair, of: Targets, pieces: Pieces) -> tuple[Bool, Bool]:
    """Return whether pieces begin, and end, with a planar pose."""
    at = elbow(pair, of.columns(), np.stack([pieces.low, pieces.high], axis=-1))
    planar = of.rho[:, None] * at.sine - np.abs(at.lead) < PLANAR
    return planar[:, 0], planar[:, 1]

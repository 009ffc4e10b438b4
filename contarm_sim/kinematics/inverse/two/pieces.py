"""Where the free parameter beta1 of two sections is feasible: the pieces of a target's one-parameter family.

The margin of `equations.elbow` is sampled between bounds that hold whatever the second section does. A piece shows
as feasible samples; as (2) passing from above one planar pose to below the other between two samples (narrow pieces:
targets near the axis); or as a largest margin between samples, which is then looked for. Ends are found by bracketing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.kinematics.inverse.two.equations import Elbow, Targets, elbow
from contarm_sim.kinematics.inverse.two.pair import Pair
from contarm_sim.kinematics.inverse.two.scalars import crossings, minima

NODES = 33
"""Samples of beta1 for each target."""

TOLERANCE = 1e-14
"""Margin that counts as none, in units of the backbone's length: a few roundings."""

_WIDTH, _NARROW = 1e-13, 1e-15  # of the bracket of an end [rad], and of a piece's only place
_STEPS = 6
_SMALL = 2e-5  # bend angle [rad] below which a corner does not tell it well


class Pieces(NamedTuple):
    """Intervals of feasible beta1 [rad], in order of their targets.

    Attributes:
        owner: index of the target of each piece, shape (n,).
        low, high: ends, shape (n,).
    """

    owner: Index
    low: Array
    high: Array

    def at(self, index: Index) -> Pieces:
        """Return some of the pieces."""
        return Pieces(self.owner[index], self.low[index], self.high[index])


def bounds(pair: Pair, targets: Targets) -> tuple[Array, Array]:
    """Return bounds of beta1 [rad], shape (n,) each, that every solution obeys.

    The elbow lies within r2 of the target, and its chord, shorter than the section's length by a factor sinc(beta1/2),
    leans by beta1/2.
    """
    far, near, length = np.sqrt(pair.ends[0][0]), np.sqrt(pair.ends[1][0]), pair.first.length
    P = np.sqrt(targets.square)
    lean, room = np.arctan2(targets.rho, targets.z), np.full_like(P, np.pi)
    beyond = far < P
    room[beyond] = np.arcsin(far / P[beyond])
    # 1 - h^2/6 <= sinc(h) <= 1 - h^2/6 + h^4/120, and the chain's factor lies between that at the limit and 1
    short = 1 - np.minimum(np.maximum(P - far, near - P) / length, 1.0)
    most = 2 * np.sqrt(12 * short / (1 + np.sqrt(np.maximum(1 - 1.2 * short, 0.0))))
    most[short > 1 / 1.2] = np.pi
    limit = 0.5 * pair.limits[0]
    factor = float(pair.first.chord(np.array([limit]))[0] * limit / (length * np.sin(limit)))
    least = 2 * np.sqrt(6 * np.maximum(1 - (P + far) / (length * factor), 0.0))
    high = np.minimum(np.minimum(2 * (lean + room), most) + 2e-7, pair.limits[0])
    low = np.maximum(np.maximum(2 * (lean - room), least) - 2e-7, 0.0)
    if pair.first.links != 1:  # a single joint is the corner itself, whatever it bends
        most_t, least_t = _corners(pair, targets)
        high = np.minimum(high, np.maximum(_bend_of_corner(pair, most_t), _SMALL))
        bend = _bend_of_corner(pair, least_t)
        low = np.where(bend > _SMALL, np.maximum(low, bend), low)
    return np.minimum(low, high), high


def _corners(pair: Pair, targets: Targets) -> tuple[Array, Array]:
    """Return the most and the least distance t1 of section 1's corner for which (1) has a beta2 within its limits."""
    (square_most, b_most), (square_least, b_least) = pair.ends
    most, least = np.full_like(targets.z, np.inf), np.zeros_like(targets.z)
    straight, bent = 2 * (targets.z + b_most), 2 * (targets.z + b_least)
    up, down = bent > 0, bent < 0
    rest = targets.square - square_least
    most[up] = rest[up] / bent[up]
    least[down] = rest[down] / bent[down]
    above = straight > 0
    least[above] = np.maximum(least[above], (targets.square[above] - square_most) / straight[above])
    return most, least


def _bend_of_corner(pair: Pair, t1: Array) -> Array:
    """Return the bend angle [rad] of section 1 whose corner is at a distance t1: Newton steps from the limit down."""
    first, limit = pair.first, 0.5 * pair.limits[0]
    wanted = 0.5 * first.length / np.maximum(t1, 1e-300)
    h = np.full_like(t1, limit)
    for _ in range(_STEPS):
        value, slope = h / np.tan(h), 1 / h - 2 / np.sin(2 * h)
        if first.links:
            x = h / first.links
            value *= np.tan(x) / x
            slope -= (1 / x - 2 / np.sin(2 * x)) / first.links
        y = h * h - 2 * h * (value - wanted) / (slope * value)
        h = np.sqrt(np.minimum(np.maximum(y, 1e-12), limit * limit))
    return np.where(wanted >= 1, 0.0, 2 * h)


def find(pair: Pair, targets: Targets, nodes: int = NODES) -> Pieces:
    """Return the pieces of targets of shape (n,); a target that none is found of has none, or is on the boundary."""
    low, high = bounds(pair, targets)
    share = np.linspace(0, 1, nodes)
    share = 0.5 * share + 0.25 * (1 - np.cos(np.pi * share))  # twice as dense at the ends
    beta1 = low[:, None] + (high - low)[:, None] * share
    at = elbow(pair, targets.columns(), beta1)
    at.margin[...] += TOLERANCE
    found = _joined(_sampled(beta1, at.margin), _between(pair, targets, beta1, at))
    owner = np.concatenate([found.owner, found.owner])

    def margin(x: Array, index: Index) -> Array:
        return elbow(pair, targets.at(owner[index]), x).margin + TOLERANCE

    inside, out = (np.concatenate(x, axis=1) for x in ((found.first, found.last), (found.before, found.after)))
    ends = crossings(margin, out[0], inside[0], out[1], inside[1], _WIDTH)
    low, high = np.split(ends, 2)
    order = np.lexsort((low, found.owner))
    return Pieces(found.owner, low, high).at(order)


class _Brackets(NamedTuple):
    """Of each piece its owner, first and last feasible place known, and infeasible ones before and after.

    Places are two rows, beta1 and margin; at the end of the samples the feasible one stands for what is beyond.
    """

    owner: Index
    first: Array
    last: Array
    before: Array
    after: Array


def _joined(one: _Brackets, other: _Brackets) -> _Brackets:
    return _Brackets(*(np.concatenate(x, axis=-1) for x in zip(one, other, strict=True)))


def _sampled(beta1: Array, margin: Array) -> _Brackets:
    """Return the pieces that samples lie on."""
    good = margin >= 0
    begins, ends = good.copy(), good.copy()
    begins[:, 1:] &= ~good[:, :-1]
    ends[:, :-1] &= ~good[:, 1:]
    (row, first), (_, last) = np.nonzero(begins), np.nonzero(ends)
    places = first, last, np.maximum(first - 1, 0), np.minimum(last + 1, beta1.shape[1] - 1)
    return _Brackets(row, *(np.stack([beta1[row, k], margin[row, k]]) for k in places))


def _between(pair: Pair, targets: Targets, beta1: Array, at: Elbow) -> _Brackets:
    """Return the pieces between samples."""
    M = at.margin
    rows = []
    for (row, left, right), look in ((_passes(at), _passed), (_tops(M), _topped)):
        if not row.size:
            continue
        before, after = (np.stack([beta1[row, k], M[row, k]]) for k in (left, right))
        inside = np.stack(look(pair, targets.at(row), beta1, at, row, left, right))
        keep = inside[1] >= 0
        rows.append(_Brackets(row[keep], *(x[:, keep] for x in (inside, inside, before, after))))
    if not rows:
        none = np.empty((2, 0))
        return _Brackets(np.empty(0, dtype=np.intp), none, none, none, none)
    return rows[0] if len(rows) == 1 else _joined(*rows)


Cells = tuple[Index, Index, Index]
"""Rows of samples, and the samples on the left and right of where a piece may be."""


def _passes(at: Elbow) -> Cells:
    """Return where (2) passes from one planar pose beyond the other between two samples."""
    bad = at.margin < 0
    row, left = np.nonzero(((at.lead[:, 1:] > 0) != (at.lead[:, :-1] > 0)) & bad[:, 1:] & bad[:, :-1])
    return row, left, left + 1


def _passed(
    pair: Pair, of: Targets, beta1: Array, at: Elbow, row: Index, left: Index, right: Index
) -> tuple[Array, Array]:
    """Return where (2) passes through 0, and the margin there."""
    sign = np.where(at.lead[row, left] > 0, -1.0, 1.0)
    x = crossings(
        lambda x, i: sign[i] * elbow(pair, of.at(i), x).lead,
        beta1[row, left], beta1[row, right], sign * at.lead[row, left], sign * at.lead[row, right], _NARROW,
    )  # fmt: skip
    return x, elbow(pair, of, x).margin + TOLERANCE


def _tops(M: Array) -> Cells:
    """Return where a largest margin, though negative at the samples, may be positive between them."""
    good = M >= 0
    rise, fall = np.zeros_like(M), np.zeros_like(M)  # from the left, to the right
    rise[:, 1:] = M[:, 1:] - M[:, :-1]
    fall[:, :-1] = -rise[:, 1:]
    tops = ~good & (rise >= 0) & (fall >= 0) & (M + rise + fall > 0)
    tops[:, 1:] &= ~good[:, :-1]
    tops[:, :-1] &= ~good[:, 1:]
    row, k = np.nonzero(tops)
    return row, np.maximum(k - 1, 0), np.minimum(k + 1, M.shape[1] - 1)


def _topped(
    pair: Pair, of: Targets, beta1: Array, at: Elbow, row: Index, left: Index, right: Index
) -> tuple[Array, Array]:
    """Return where the margin is largest, and how large."""
    middle = np.where(at.margin[row, left] >= at.margin[row, right], left, right)
    middle = np.where(right - left == 2, left + 1, middle)
    values = -at.margin[row, left], -at.margin[row, middle], -at.margin[row, right]
    x, f = minima(
        lambda x, i: -elbow(pair, of.at(i), x).margin - TOLERANCE,
        beta1[row, left], beta1[row, middle], beta1[row, right], values, 30, 1e-10,
    )  # fmt: skip
    return x, -f

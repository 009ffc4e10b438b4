"""Newton steps for bends of two sections: to the target, and along the curve of solutions there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.scalars import Index
from contarm_sim.kinematics.inverse.two_pair import Pair
from contarm_sim.kinematics.inverse.two_tip import Columns, columns, in_base, tips

ENOUGH = 1e-15
"""Miss that no polish is wanted for, in units of the backbone's length."""

_CLOSE = 1e-2  # miss up to which steps are taken, in units of length
_DAMPING = 1e-15  # of the Newton step, in squared lengths: it keeps the direction that a fold lacks still
_OVER, _CLEARLY = 2e-15, 1e-9  # bend angles above a limit [rad]: less is simply cut off
_NEARLY, _NOTHING = 1e-2, 1e-12  # residuals from which, and below which, sliding is no use
_DIFFERENCE = 1e-6  # change of the bends [rad] for derivatives along the curve


def polish(pair: Pair, points: Array, bends: Array, steps: int = 6) -> tuple[Array, Array]:
    """Return bends and their misses after Newton steps of least change, taken only where they come nearer.

    Args:
        pair: the sections.
        points: targets in units of length, shape (n, 3).
        bends: near a solution [rad], shape (n, 2, 2); where it is at a limit, it stays there or goes inwards.
        steps: most Newton steps.
    """
    miss = _distance(tips(pair, bends), points)
    bends, left = bends.copy(), np.flatnonzero((miss > ENOUGH) & (miss < _CLOSE))
    for _ in range(steps):
        if not left.size:
            break
        new = _step(pair, points[left], bends[left])
        new_miss = _distance(tips(pair, new), points[left])
        better = new_miss < miss[left]
        bends[left[better]], miss[left[better]] = new[better], new_miss[better]
        left = left[better & (new_miss > ENOUGH)]
    return bends, miss


def _distance(one: Array, other: Array) -> Array:
    x, y, z = (one - other).T
    return np.hypot(np.hypot(x, y), z)


def _step(pair: Pair, points: Array, bends: Array) -> Array:
    at = columns(pair, bends)
    gap = points - in_base(at, *at.tip)
    nx, ny = at.first.nx, at.first.ny
    e = [gap[:, 0] * nx + gap[:, 1] * ny, gap[:, 1] * nx - gap[:, 0] * ny, gap[:, 2]]
    free = np.ones((2, len(bends)))
    limits = pair.limits
    for _ in range(3):
        parts = _least_change(at, e, free)
        out = bends + _bend_steps(at, parts)
        angle = np.hypot(out[..., 0], out[..., 1])
        over = [(angle[:, k] - limits[k]) * free[k] for k in (0, 1)]
        # a second bend angle only stays if it is clearly over: else the step could do nothing
        least = np.where(free.sum(axis=0) < 2, _CLEARLY, _OVER)
        stuck = [(over[k] > least) & ((over[k] >= over[1 - k]) | (over[k] > _CLEARLY)) for k in (0, 1)]
        if not (stuck[0].any() or stuck[1].any()):
            break
        free = np.where(stuck, 0.0, free)
    return out * np.minimum(limits / np.maximum(angle, 1e-300), 1.0)[..., None]


def _bend_steps(at: Columns, parts: list[Array]) -> Array:
    along1, across1, along2, across2 = parts
    one, two = at.first, at.second
    rows = [
        along1 * one.nx - across1 * one.ny, along1 * one.ny + across1 * one.nx,
        along2 * two.nx - across2 * two.ny, along2 * two.ny + across2 * two.nx,
    ]  # fmt: skip
    return np.stack(rows, axis=-1).reshape(-1, 2, 2)


def _least_change(at: Columns, e: list[Array], free: Array) -> list[Array]:
    """Return the smallest change of the bends that moves the tip by e; bend angles that are not free stay."""
    J = [
        [x * free[0] for x in at.along1], at.across1,
        [x * free[1] for x in at.along2], at.across2,
    ]  # fmt: skip

    def product(i: int, k: int) -> Array:
        return J[0][i] * J[0][k] + J[1][i] * J[1][k] + J[2][i] * J[2][k] + J[3][i] * J[3][k]

    # Cholesky factors of J J' + damping, by hand
    l00 = np.sqrt(product(0, 0) + _DAMPING)
    l10, l20 = product(1, 0) / l00, product(2, 0) / l00
    l11 = np.sqrt(np.maximum(product(1, 1) - l10 * l10, 0.0) + _DAMPING)
    l21 = (product(2, 1) - l20 * l10) / l11
    l22 = np.sqrt(np.maximum(product(2, 2) - l20 * l20 - l21 * l21, 0.0) + _DAMPING)
    y0 = e[0] / l00
    y1 = (e[1] - l10 * y0) / l11
    y2 = (e[2] - l20 * y0 - l21 * y1) / l22
    x2 = y2 / l22
    x1 = (y1 - l21 * x2) / l11
    x0 = (y0 - l10 * x1 - l20 * x2) / l00
    return [column[0] * x0 + column[1] * x1 + column[2] * x2 for column in J]


def slide(
    pair: Pair, points: Array, bends: Array, miss: Array, residual: Callable[[Array, Index], Array]
) -> tuple[Array, Array]:
    """Return bends and misses after steps along the curve of solutions that bring a residual nearer to 0.

    For solutions at which the residual is 0 or nearly so: Gauss-Newton steps, taken only where they help.

    Args:
        pair: the sections.
        points: targets in units of length, shape (n, 3).
        bends: that reach them [rad], shape (n, 2, 2).
        miss: distances that are left, shape (n,).
        residual: of bends (k, 2, 2) and the rows that they are of (k,), shape (k, r).
    """
    bends, miss = bends.copy(), miss.copy()
    size = np.linalg.norm(residual(bends, np.arange(len(bends))), axis=-1)
    left = np.flatnonzero((size < _NEARLY) & (size > _NOTHING))
    for _ in range(4):
        if not left.size:
            break
        along, start = _along_curve(columns(pair, bends[left])), bends[left]
        r = residual(start, left)
        rate = (residual(start + _DIFFERENCE * along, left) - residual(start - _DIFFERENCE * along, left)) / (
            2 * _DIFFERENCE
        )
        step = -(r * rate).sum(axis=-1) / np.maximum((rate * rate).sum(axis=-1), 1e-300)
        new = start + step[:, None, None] * along
        angle = np.hypot(new[..., 0], new[..., 1])
        new *= np.minimum(pair.limits / np.maximum(angle, 1e-300), 1.0)[..., None]
        new, new_miss = polish(pair, points[left], new)
        new_size = np.linalg.norm(residual(new, left), axis=-1)
        better = (new_size < size[left]) & (new_miss <= np.maximum(miss[left], 2 * ENOUGH))
        kept = left[better]
        bends[kept], miss[kept], size[kept] = new[better], new_miss[better], new_size[better]
        left = kept[size[kept] > _NOTHING]
    return bends, miss


def _along_curve(at: Columns) -> Array:
    """Return unit changes of the bends that leave the tip still, shape (n, 2, 2); 0 where that is any."""
    J = at.along1, at.across1, at.along2, at.across2

    def across(i: int, j: int) -> list[Array]:
        (a, b, c), (d, e, f) = J[i], J[j]
        return [b * f - c * e, c * d - a * f, a * e - b * d]

    def volume(i: int, pair: list[Array]) -> Array:
        return J[i][0] * pair[0] + J[i][1] * pair[1] + J[i][2] * pair[2]

    first, last = across(0, 1), across(2, 3)
    null = [volume(1, last), -volume(0, last), volume(3, first), -volume(2, first)]
    size = np.maximum(np.sqrt(sum(x * x for x in null)), 1e-300)
    return _bend_steps(at, [x / size for x in null])

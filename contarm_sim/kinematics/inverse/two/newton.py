"""Newton steps for bends of two sections: to the target, and along the curve of solutions there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.limits import angles_of, clamped
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.kinematics.inverse.tips import tips_and_jacobians
from contarm_sim.kinematics.inverse.two.pair import Pair

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
    gap, J = _evaluated(pair, points, bends)
    miss = _size(gap)
    bends, left = bends.copy(), np.flatnonzero((miss > ENOUGH) & (miss < _CLOSE))
    gap, J = gap[left], J[left]
    for _ in range(steps):
        if not left.size:
            break
        new = _step(pair, gap, J, bends[left])
        gap, J = _evaluated(pair, points[left], new)
        new_miss = _size(gap)
        better = new_miss < miss[left]
        bends[left[better]], miss[left[better]] = new[better], new_miss[better]
        on = better & (new_miss > ENOUGH)
        left, gap, J = left[on], gap[on], J[on]
    return bends, miss


def _evaluated(pair: Pair, points: Array, bends: Array) -> tuple[Array, Array]:
    """Return what is left to the targets, shape (n, 3), and the tip's derivatives by the bends, shape (n, 6, 4)."""
    tip, _, J = tips_and_jacobians(bends, pair.backbone)
    return points - tip, J


def _size(gap: Array) -> Array:
    x, y, z = gap.T
    return np.hypot(np.hypot(x, y), z)


def _step(pair: Pair, gap: Array, J: Array, bends: Array) -> Array:
    columns = np.ascontiguousarray(J[:, :3].transpose(2, 1, 0))
    free, limits = np.ones((2, len(bends))), pair.limits
    for _ in range(3):
        out = bends + _least_change(_freed(columns, bends, free), gap.T)
        angle = angles_of(out)
        over = [(angle[:, k] - limits[k]) * free[k] for k in (0, 1)]
        # a second bend angle only stays if it is clearly over: else the step could do nothing
        least = np.where(free.sum(axis=0) < 2, _CLEARLY, _OVER)
        stuck = [(over[k] > least) & ((over[k] >= over[1 - k]) | (over[k] > _CLEARLY)) for k in (0, 1)]
        if not (stuck[0].any() or stuck[1].any()):
            break
        free = np.where(stuck, 0.0, free)
    return clamped(out, pair.backbone)


def _freed(columns: Array, bends: Array, free: Array) -> Array:
    """Return derivatives, shape (4, 3, n), without the part by bend angles that are not free."""
    if free.all():
        return columns
    out = columns.copy()
    angle = angles_of(bends)[..., None]
    normals = np.where(angle > 0, bends / np.maximum(angle, 1e-300), [1.0, 0.0])
    for k in (0, 1):
        nx, ny = normals[:, k].T
        held = (columns[2 * k] * nx + columns[2 * k + 1] * ny) * (1 - free[k])
        out[2 * k] -= held * nx
        out[2 * k + 1] -= held * ny
    return out


def _least_change(J: Array, e: Array) -> Array:
    """Return the smallest change of the bends, shape (n, 2, 2), that moves the tip by e, shape (3, n)."""

    def product(i: int, k: int) -> Array:
        return J[0, i] * J[0, k] + J[1, i] * J[1, k] + J[2, i] * J[2, k] + J[3, i] * J[3, k]

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
    return np.asarray((J[:, 0] * x0 + J[:, 1] * x1 + J[:, 2] * x2).T.reshape(-1, 2, 2))


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
        along, start = _along_curve(pair, bends[left]), bends[left]
        r = residual(start, left)
        rate = (residual(start + _DIFFERENCE * along, left) - residual(start - _DIFFERENCE * along, left)) / (
            2 * _DIFFERENCE
        )
        step = -(r * rate).sum(axis=-1) / np.maximum((rate * rate).sum(axis=-1), 1e-300)
        new, new_miss = polish(pair, points[left], clamped(start + step[:, None, None] * along, pair.backbone))
        new_size = np.linalg.norm(residual(new, left), axis=-1)
        better = (new_size < size[left]) & (new_miss <= np.maximum(miss[left], 2 * ENOUGH))
        kept = left[better]
        bends[kept], miss[kept], size[kept] = new[better], new_miss[better], new_size[better]
        left = kept[size[kept] > _NOTHING]
    return bends, miss


def _along_curve(pair: Pair, bends: Array) -> Array:
    """Return unit changes of the bends that leave the tip still, shape (n, 2, 2); 0 where that is any."""
    a, b, c, d = np.ascontiguousarray(tips_and_jacobians(bends, pair.backbone)[2][:, :3].transpose(2, 1, 0))

    def volume(i: Array, j: Array, k: Array) -> Array:
        across = [j[1] * k[2] - j[2] * k[1], j[2] * k[0] - j[0] * k[2], j[0] * k[1] - j[1] * k[0]]
        return i[0] * across[0] + i[1] * across[1] + i[2] * across[2]

    null = np.stack([volume(b, c, d), -volume(a, c, d), volume(d, a, b), -volume(c, a, b)], axis=-1)
    size = np.maximum(np.sqrt((null * null).sum(axis=-1)), 1e-300)
    return np.asarray((null / size[:, None]).reshape(-1, 2, 2))

"""The nearest point of the dome for any target at all: the foot bracketed on a grid, and the rim if that is nearer.

`nearest` says what foot, rim and F are, and that F changes sign from - to + once at most.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from contarm_sim.kinematics.arrays import Array, sinc_and_slope
from contarm_sim.kinematics.nearest import LARGEST_HALF


def search_nearest(rho: Array, z: Array) -> tuple[Array, Array]:
    """Return half the bend angle [rad] at the dome's points nearest to targets, and their distances, shape (n,) each.

    Args:
        rho: distances from the axis of symmetry in units of length, shape (n,).
        z: heights in units of length, shape (n,).
    """
    grid, (rate_rho, rate_z), towards_middle = _grid()
    slopes = towards_middle - rho[:, None] * rate_rho
    slopes -= z[:, None] * rate_z
    slopes[:, 0] = -1.0  # it is -rho, never positive
    positive = slopes > 0
    found = np.flatnonzero(positive.any(axis=1))
    first = positive[found].argmax(axis=1)
    h = np.full(rho.shape, LARGEST_HALF)
    h[found] = _bracketed(grid[first - 1], grid[first], rho[found], z[found])
    distance = _distance(h, rho, z)
    to_rim = _distance(np.full_like(h, LARGEST_HALF), rho, z)
    rim = ~positive[:, -1] & (to_rim < distance)
    h[rim], distance[rim] = LARGEST_HALF, to_rim[rim]
    return h, distance


@cache
def _grid() -> tuple[Array, tuple[Array, Array], Array]:
    """Return values of h, the profile's derivative there, and the product of both.

    Towards the rim they come closer by halves: a foot that is nearer than the rim lies at least twice as far from it
    (in h) as the maximum between them, because F is concave there, so one of the values tells the two apart.
    """
    h = np.union1d(np.linspace(0, LARGEST_HALF, 17), LARGEST_HALF * (1 - 0.5 ** np.arange(1.0, 21.0)))
    (m_rho, m_z), rate, _ = _profile(h)
    return h, rate, m_rho * rate[0] + m_z * rate[1]


def _profile(h: Array) -> tuple[tuple[Array, Array], ...]:
    """Return m(h) and its first and second derivative by h, each a pair (rho, z)."""
    y = h * h
    c, g = sinc_and_slope(y)
    k = c + y * g
    turn = 2 * h * (g * k - c * g - c * c), -2 * ((c + g) * k + y * g * c)
    return (h * c * c, c * k), (c * (k + y * g), h * (g * k - c * c)), turn


def _bracketed(low: Array, high: Array, rho: Array, z: Array) -> Array:
    """Solve for the foot between `low` and `high` by Newton steps that may not leave the bracket, else by halving."""
    h = 0.5 * (low + high)
    h[(rho == 0) & (low == 0) & (z >= 0.25)] = 0.0  # the apex
    left = np.flatnonzero(h)
    for _ in range(100):
        at = h[left]
        (off_rho, off_z), (rate_rho, rate_z), (turn_rho, turn_z) = _profile(at)
        off_rho, off_z = off_rho - rho[left], off_z - z[left]
        slope = off_rho * rate_rho + off_z * rate_z
        second = rate_rho * rate_rho + rate_z * rate_z + off_rho * turn_rho + off_z * turn_z
        rising = slope > 0
        low[left[~rising]], high[left[rising]] = at[~rising], at[rising]
        newton = at - slope / np.where(second > 0, second, np.inf)
        inside = (newton >= low[left]) & (newton <= high[left]) & (second > 0)
        new = np.where(inside, newton, 0.5 * (low[left] + high[left]))
        unsure = np.abs(slope) > 1e-15 * (np.abs(off_rho * rate_rho) + np.abs(off_z * rate_z))  # not mere rounding
        left, new = left[unsure], new[unsure]
        h[left] = new
        left = left[np.abs(new - at[unsure]) > 2e-15 * new]
        if not left.size:
            break
    return h


def _distance(h: Array, rho: Array, z: Array) -> Array:
    m_rho, m_z = _profile(h)[0]
    return np.hypot(m_rho - rho, m_z - z)

"""Tension along a tendon that rubs in its guides, by the law of the capstan: dT/ds = -m k(s) T.

k is the curvature of the tendon's path and m the coefficient of friction with the sign of the slip: m > 0 where the
tendon slides towards its start, which then has the highest tension. A tendon of tension T_0 at its start has
T(s) = T_0 exp(-m W(s)), W the angle by which it has turned up to s (Euler 1762, Eytelwein 1808).

Its path is cut into pieces. Piece j turns by a_j, evenly spread over its length (`spread`), or all at its start, as a
straight span behind a disk does (`at_disks`). Its mean tension is T_0 g_j, with W_j the turning of the pieces before
and f(y) = (1 - exp(-y))/y:

    spread:    g_j = exp(-m W_j) f(m a_j)
    at disks:  g_j = exp(-m (W_j + a_j))
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.kinematics.arrays import Array

SERIES = 1e-3
"""Below this the slope of f is a series: its closed form would be all rounding."""


@dataclass(frozen=True)
class Profile:
    """Mean tensions of the J pieces of tendons, over the tension at their start, and their slopes; shape (..., J) each.

    Attributes:
        share: g_j.
        by_friction: dg_j/dm.
        before: dg_j/da_k for pieces k before piece j, the same for all of them.
        own: dg_j/da_j.
        end: the tension at the end, shape (...).
    """

    share: Array
    by_friction: Array
    before: Array
    own: Array
    end: Array


def spread(friction: Array, turning: Array) -> Profile:
    """Return the profile of tendons along pieces that turn evenly.

    Args:
        friction: m, shape (...).
        turning: a_j [rad], shape (..., J), none below 0.
    """
    m, total = np.asarray(friction)[..., None], np.cumsum(turning, axis=-1)
    W, y = total - turning, m * turning
    fallen, (f, slope) = np.exp(-m * W), _mean_of_fall(y)
    share, own = fallen * f, fallen * slope
    return Profile(share, own * turning - W * share, -m * share, m * own, np.exp(-(m * total)[..., -1]))


def at_disks(friction: Array, turning: Array) -> Profile:
    """Return the profile of tendons in straight pieces, each behind a disk at which they turn; see `spread`."""
    m, total = np.asarray(friction)[..., None], np.cumsum(turning, axis=-1)
    share = np.exp(-m * total)
    return Profile(share, -total * share, -m * share, -m * share, share[..., -1])


def _mean_of_fall(y: Array) -> tuple[Array, Array]:
    """Return f(y) = (1 - exp(-y))/y and its slope."""
    small = np.abs(y) < SERIES
    safe = np.where(small, 1.0, y)
    f = np.where(small, 1 - y / 2 + y**2 / 6, -np.expm1(-safe) / safe)
    slope = np.where(small, -0.5 + y / 3 - y**2 / 8, (np.exp(-safe) * (1 + safe) - 1) / safe**2)
    return f, slope

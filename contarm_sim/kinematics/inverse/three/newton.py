"""Newton's method on poses of three sections: from a few digits to rounding."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import excess

SOLVED = 1e-13
"""Miss of a solution, as a fraction of the length; Newton's method leaves rounding, mostly below 1e-15."""

_STEPS = 30
_ROUNDING = 4e-16
_LONGEST = 0.5  # of a step [rad]


def refined(goals: Goals, bends: Array, backbone: Backbone, least_singular: float = 0.0) -> tuple[Array, Array, Array]:
    """Return bends that reach poses [rad], their misses as fractions of the length, shape (n,), and Jacobians.

    Args:
        goals: poses.
        bends: starts [rad], shape (n, 3, 2).
        backbone: three sections.
        least_singular: directions of smaller singular values, as a fraction of the largest, are left alone.
    """
    best, least, jacobians = bends, np.full(len(bends), np.inf), np.zeros((len(bends), 6, 6))
    at, going = bends, np.arange(len(bends))
    for _ in range(_STEPS):
        off, J = (goals if len(going) == len(bends) else goals.take(going)).terms(at, backbone)
        size = np.sqrt(np.sum(off * off, axis=-1))
        better = size < least[going]
        if better.all() and len(going) == len(bends):
            best, least, jacobians = at, size, J
        else:
            if len(going) == len(bends):
                best, least, jacobians = best.copy(), least.copy(), jacobians.copy()
            which = going[better]
            best[which], least[which], jacobians[which] = at[better], size[better], J[better]
        # A step from 1e-8 leaves rounding; what stays above it is nearly singular, and comes closer by halves.
        on = (size > _ROUNDING) & (better | (size > SOLVED)) & (size < 10)
        if not on.any():
            break
        if not on.all():
            going, at, off, J = going[on], at[on], off[on], J[on]
        at = at + _short(_solved(J, off, least_singular)).reshape(at.shape)
    return best, least, jacobians


def polished(goals: Goals, bends: Array, backbone: Backbone) -> Array:
    """Return solutions next to bends [rad], shape (n, 3, 2), or the bends given where none within the limits is."""
    better, miss, _ = refined(goals, bends, backbone)
    return np.where(((miss <= SOLVED) & (excess(better, backbone) <= 0))[:, None, None], better, bends)


def _solved(J: Array, off: Array, least_singular: float) -> Array:
    if least_singular == 0:
        try:
            return np.asarray(np.linalg.solve(J, off[..., None])[..., 0])
        except np.linalg.LinAlgError:
            least_singular = 1e-12
    return np.asarray((np.linalg.pinv(J, rcond=least_singular) @ off[..., None])[..., 0])


def _short(step: Array) -> Array:
    length = np.sqrt(np.sum(step * step, axis=-1, keepdims=True))
    return np.asarray(step * np.minimum(1.0, _LONGEST / (length + 1e-300)))

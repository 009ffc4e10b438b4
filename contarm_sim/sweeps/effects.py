"""How much of a quantity's variance lies between the levels of a parameter, and whether chance alone makes as much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array

SURE = 0.01
"""Chance below which an effect is taken for one."""

_BINS, _CASES = 8, 3
"""Most bins, and fewest cases in each level or bin on average."""


@dataclass(frozen=True)
class Effect:
    """Of a parameter on a quantity.

    Attributes:
        share: of the variance between levels, without what chance puts there (omega squared; Hays 1963), 0 or more.
        chance: probability of as much or more if the parameter had no effect (F test).
    """

    share: float
    chance: float


def effect(parameter: NDArray[Any], values: Array, drawn: bool = False) -> Effect:
    """Return the effect of a parameter, numbers or texts of shape (K,), on values, shape (K,), NaN where there is none.

    Numbers that are drawn from a range, or have too few cases each, are taken together with their neighbours.
    """
    from scipy.special import fdtrc

    known = np.isfinite(values)
    place, y = _groups(parameter[known], drawn), values[known]
    size = np.bincount(place)
    between_free, within_free = len(size) - 1, len(y) - len(size)
    if between_free < 1 or within_free < 1 or np.ptp(y) == 0:
        return Effect(0.0, 1.0)
    whole = float(((y - y.mean()) ** 2).sum())
    between = float((size * (np.bincount(place, y) / size - y.mean()) ** 2).sum())
    within = max(whole - between, 1e-15 * whole) / within_free
    share = (between - between_free * within) / (whole + within)
    return Effect(max(share, 0.0), float(fdtrc(between_free, within_free, between / between_free / within)))


def _groups(parameter: NDArray[Any], drawn: bool) -> NDArray[np.intp]:
    """Return the number of the level or bin of each case."""
    numeric = np.issubdtype(parameter.dtype, np.number)
    levels, place = np.unique(parameter if numeric else parameter.astype(str), return_inverse=True)
    count = len(levels)
    if not numeric or (count * _CASES <= len(parameter) and not drawn):
        return np.asarray(place)
    bins = min(_BINS, max(2, len(parameter) // _CASES), count)
    return np.asarray(place * bins // count)

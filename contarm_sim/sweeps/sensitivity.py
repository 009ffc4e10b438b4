"""Sobol's indices of a finished table: which parameter causes how much of a quantity's variance, and how surely."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array

RESAMPLED = 999
"""How often points are drawn again for the intervals."""

LEVEL = 95.0
"""Share that the intervals hold [%]."""

LEAST_POINTS = 8
"""Fewer points say nothing."""


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class Indices:
    """Sobol's indices of one quantity.

    Attributes:
        names: of the parameters.
        first: share of the variance that each causes alone, shape (d,).
        total: the same, with all that it causes together with others, shape (d,).
        first_interval, total_interval: confidence intervals of these, low and high, shape (2, d).
        points: base points that were used, a power of two.
        left_out: base points that were not: some case of theirs failed or is not there yet, or they are more than the
            power of two.
    """

    names: tuple[str, ...]
    first: Array
    total: Array
    first_interval: Array
    total_interval: Array
    points: int
    left_out: int


def sobol(names: tuple[str, ...], f_a: Array, f_b: Array, f_ab: Array) -> Indices:
    """Return Sobol's indices from values at the points of Saltelli's design, with bootstrapped confidence intervals.

    Args:
        names: of the d parameters.
        f_a, f_b: the quantity at points of A and B, shape (n,); NaN where there is none.
        f_ab: at those of A, with parameter i from B, shape (d, n).

    Raises:
        InputError: too few points without a gap.
    """
    from scipy.stats import sobol_indices

    whole = np.flatnonzero(np.isfinite(f_a) & np.isfinite(f_b) & np.isfinite(f_ab).all(axis=0))
    if len(whole) < LEAST_POINTS:
        raise InputError("points", f"{len(whole)} without a failed or missing case", f"at least {LEAST_POINTS}")
    used = whole[: 2 ** (len(whole).bit_length() - 1)]
    n = len(used)

    def indices(rows: NDArray[np.integer[Any]]) -> Array:
        values = {"f_A": f_a[None, rows], "f_B": f_b[None, rows], "f_AB": f_ab[:, None, rows]}
        found = sobol_indices(func=values, n=n)
        return np.array([found.first_order, found.total_order]).reshape(2, len(names))

    rng = np.random.default_rng(0)  # the same table has the same intervals
    again = np.array([indices(rng.choice(used, n)) for _ in range(RESAMPLED)])
    low, high = np.quantile(again, (0.5 - LEVEL / 200, 0.5 + LEVEL / 200), axis=0)
    first, total = indices(used)
    intervals = np.stack([low, high], axis=1)
    return Indices(names, first, total, intervals[0], intervals[1], n, len(f_a) - n)

"""Sobol's indices of a finished table: which parameter causes how much of a quantity's variance, and how surely."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.sweeps.causes import MOST_FAILED
from contarm_sim.sweeps.table import Sweep

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
        failed: base points that were not, as some case of theirs has no result.
        surplus: base points that were not, for there to be a power of two.
    """

    names: tuple[str, ...]
    first: Array
    total: Array
    first_interval: Array
    total_interval: Array
    points: int
    failed: int
    surplus: int


def sobol(names: tuple[str, ...], f_a: Array, f_b: Array, f_ab: Array) -> Indices:
    """Return Sobol's indices from values at the points of Saltelli's design, with bootstrapped confidence intervals.

    Args:
        names: of the d parameters.
        f_a, f_b: the quantity at points of A and B, shape (n,); NaN where there is none.
        f_ab: at those of A, with parameter i from B, shape (d, n).

    Raises:
        InputError: too few points without a gap, or more than `MOST_FAILED` of them with one: what fails is not drawn
            by chance, so the others stand for other ranges; or a quantity that is the same everywhere.
    """
    from scipy.stats import sobol_indices

    whole = np.flatnonzero(np.isfinite(f_a) & np.isfinite(f_b) & np.isfinite(f_ab).all(axis=0))
    if len(whole) < LEAST_POINTS:
        raise InputError("points", f"{len(whole)} without a failed or missing case", f"at least {LEAST_POINTS}")
    failed = len(f_a) - len(whole)
    if failed > MOST_FAILED * len(f_a):
        raise InputError("points", f"{failed} of {len(f_a)} with a failed case", f"at most {100 * MOST_FAILED:g} %")
    used = whole[: 2 ** (len(whole).bit_length() - 1)]  # SciPy takes no other number
    n = len(used)
    if np.ptp(f_a[used]) == 0:
        raise InputError("quantity", "the same in all cases", "one that varies")

    def indices(rows: NDArray[np.integer[Any]]) -> Array:
        values = {"f_A": f_a[None, rows], "f_B": f_b[None, rows], "f_AB": f_ab[:, None, rows]}
        found = sobol_indices(func=values, n=n)
        return np.array([found.first_order, found.total_order]).reshape(2, len(names))

    # SciPy's own bootstrap draws from NumPy's global random state, and its jackknife (BCa) takes memory of n^2 numbers.
    rng = np.random.default_rng(0)  # the same table has the same intervals
    again = np.array([indices(rng.choice(used, n)) for _ in range(RESAMPLED)])
    low, high = np.quantile(again, (0.5 - LEVEL / 200, 0.5 + LEVEL / 200), axis=0)
    first, total = indices(used)
    intervals = np.stack([low, high], axis=1)
    return Indices(names, first, total, intervals[0], intervals[1], n, failed, len(whole) - n)


def indices_of(sweep: Sweep, quantity: str) -> Indices:
    """Return Sobol's indices of a quantity of a sweep, from the points all cases of which are done.

    Raises:
        InputError: the sweep is not designed for them, or see `sobol`.
    """
    spec, names = sweep.spec, tuple(sweep.spec.vary)
    if spec.design != "sobol-indices" or len(names) < 2:
        raise InputError("design", f"{spec.design} of {len(names)}", "sobol-indices of two parameters or more")
    points, matrix, values = sweep.column("point"), sweep.column("matrix"), sweep.values(quantity)
    kinds = ("A", "B", *(f"AB:{name}" for name in names))
    of = np.full((len(kinds), spec.drawn), np.nan)
    done = np.zeros(of.shape, dtype=bool)
    for row, kind in enumerate(kinds):
        own = matrix == kind
        of[row, points[own]], done[row, points[own]] = values[own], True
    f_a, f_b, *f_ab = of[:, done.all(axis=0)]
    return sobol(names, f_a, f_b, np.array(f_ab))

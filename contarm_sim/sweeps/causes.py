"""Which uncertain parameter causes the spread of a quantity: Sobol indices, from the cases that are there anyway.

The exact way (Saltelli 2010) takes cases (d + 2) times for d parameters. Here a polynomial in the parameters,
orthonormal under their distributions (polynomial chaos), is fitted to the cases by least squares, and the indices are
sums of its squared coefficients (Sudret 2008, Reliability Engineering and System Safety 93). Of polynomials up to some
degree, with parameters alone or in pairs, the one is taken that best predicts each case from the others (leave one
out). The share that it does not explain is given; where that is too large, there are no indices.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from contarm_sim.kinematics.arrays import Array

LEAST_EXPLAINED = 0.8
"""Share of the variance that a polynomial must explain for causes to be given."""

MOST_FAILED = 0.1
"""Share of cases without a result beyond which no causes are given."""

_HIGHEST, _CASES_A_TERM, _RESAMPLES = 8, 3, 300
"""Highest degree, cases that there must be for each term, samples of the bootstrap."""

_SAME = 1e-9
"""Standard deviation, over the size of the values, below which nothing is spread."""


@dataclass(frozen=True, eq=False)
class Causes:
    """Shares of the variance of a quantity, by d parameters.

    Attributes:
        first: first-order Sobol indices, shape (d,): what each causes alone.
        total: total ones, shape (d,): what each has a part in, together with others too.
        first_interval, total_interval: 95 % intervals (bootstrap over cases), shape (d, 2).
        explained: share of the variance that the polynomial explains of cases that it was not fitted to.
        degree, terms: of the polynomial.
        reason: why no causes are given, or "". Then all indices are NaN.
    """

    first: Array
    total: Array
    first_interval: Array
    total_interval: Array
    explained: float
    degree: int
    terms: int
    reason: str = ""

    @classmethod
    def untold(cls, count: int, reason: str, explained: float = math.nan) -> Causes:
        """Return what stands for unknown causes."""
        none, pairs = np.full(count, np.nan), np.full((count, 2), np.nan)
        return cls(none, none, pairs, pairs, explained, 0, 0, reason)


def causes(coordinates: Array, normal: list[bool], values: Array, seed: int = 0) -> Causes:
    """Return what causes the spread of a quantity.

    Args:
        coordinates: of the cases, shape (n, d): each a standard normal number or one that is uniform on -1..1.
        normal: which of the two, d of them.
        values: of the cases, shape (n,) or, of a quantity with m parts such as a place, (n, m): then variances are
            summed over the parts (Gamboa 2014, Electronic Journal of Statistics 8). NaN where a case has no result.
        seed: of the bootstrap.
    """
    count = coordinates.shape[1]
    if not len(values):
        return Causes.untold(count, "no case was run")
    outputs = np.asarray(values, dtype=float).reshape(len(values), -1)
    good = np.array([np.isfinite(row).all() for row in outputs], dtype=bool)
    if good.mean() < 1 - MOST_FAILED:
        return Causes.untold(count, f"{int((~good).sum())} of {len(values)} cases have no result")
    places, outputs = coordinates[good], outputs[good]
    spread = outputs - outputs.mean(axis=0)
    if np.sqrt((spread**2).sum(axis=1).mean()) <= _SAME * max(np.abs(outputs).max(), 1e-12):
        return Causes.untold(count, "it is the same in all cases")
    fits = [_fitted(powers, places, normal, spread) for powers in _bases(count, len(places))]
    if not fits:
        return Causes.untold(count, f"{len(places)} cases are too few for {count} parameters")
    explained, powers, terms = max(fits, key=lambda fit: fit[0])
    if explained < LEAST_EXPLAINED:
        reason = f"the fitted polynomial explains only {100 * max(explained, 0):.0f} % of the variance"
        return Causes.untold(count, reason, explained)
    Q, R = np.linalg.qr(terms)
    first, total = _indices(powers, np.linalg.solve(R, Q.T @ spread))
    chance, again = np.random.default_rng(seed), []
    for _ in range(_RESAMPLES):
        drawn = np.bincount(chance.integers(len(places), size=len(places)), minlength=len(places))
        weighed = Q.T * drawn
        again.append(_indices(powers, np.linalg.solve(R, np.linalg.solve(weighed @ Q, weighed @ spread))))
    one, two = (np.percentile([each[i] for each in again], (2.5, 97.5), axis=0).T for i in (0, 1))
    return Causes(first, total, one, two, explained, int(powers.sum(axis=1).max()), len(powers))


def _bases(count: int, cases: int) -> Iterator[Array]:
    """Yield sets of terms, each as powers of the parameters, shape (terms, d), that so many cases can determine."""
    for together in (1, 2)[:count]:
        for degree in range(together, _HIGHEST + 1):
            size = sum(math.comb(count, k) * math.comb(degree, k) for k in range(together + 1))
            if size * _CASES_A_TERM > cases:
                break
            yield _powers(count, degree, together)


def _powers(count: int, degree: int, together: int) -> Array:
    rows = [np.zeros(count, dtype=int)]
    for number in range(1, together + 1):
        for chosen in combinations(range(count), number):
            for own in product(range(1, degree + 1), repeat=number):
                if sum(own) <= degree:
                    rows.append(np.zeros(count, dtype=int))
                    rows[-1][list(chosen)] = own
    return np.array(rows)


def _fitted(powers: Array, places: Array, normal: list[bool], spread: Array) -> tuple[float, Array, Array]:
    """Return the share of the variance that a fit explains of each case left out, its powers, and its terms."""
    terms = np.ones((len(places), len(powers)))
    for i, gauss in enumerate(normal):
        terms *= _orthonormal(places[:, i], int(powers[:, i].max()), gauss)[:, powers[:, i]]
    Q = np.linalg.qr(terms)[0]
    left = (spread - Q @ (Q.T @ spread)) / np.maximum(1 - (Q**2).sum(axis=1), 1e-9)[:, None]
    return 1 - float((left**2).sum() / (spread**2).sum()), powers, terms


def _orthonormal(x: Array, degree: int, gauss: bool) -> Array:
    """Return Hermite's or Legendre's polynomials, of variance 1, shape (n, degree + 1)."""
    from numpy.polynomial import hermite_e, legendre

    every = np.arange(degree + 1)
    if gauss:
        return np.asarray(hermite_e.hermevander(x, degree) / np.sqrt([math.factorial(k) for k in every]))
    return np.asarray(legendre.legvander(x, degree) * np.sqrt(2 * every + 1))


def _indices(powers: Array, coefficients: Array) -> tuple[Array, Array]:
    """Return first-order and total indices, shape (d,)."""
    parts = (coefficients**2).sum(axis=1)
    there, whole = powers > 0, parts[powers.any(axis=1)].sum()
    alone = there & (there.sum(axis=1) == 1)[:, None]
    return parts @ alone / whole, parts @ there / whole

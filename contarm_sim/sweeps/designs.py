"""Which cases there are: a design over the parameters that vary, made piece by piece, so that no table is held.

grid              all combinations; the last parameter varies fastest
latin-hypercube   evenly in every parameter alone (scipy.stats.qmc.LatinHypercube)
sobol             evenly in all of them together (scrambled Sobol's points, scipy.stats.qmc.Sobol)
sobol-indices     what Sobol's indices ask for: points A and B, and A with one parameter of B (Saltelli, 2010)
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, Literal, get_args

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.sweeps.distributions import Varied
from contarm_sim.sweeps.names import Parameter

Design = Literal["grid", "latin-hypercube", "sobol", "sobol-indices"]
DESIGNS: tuple[Design, ...] = get_args(Design)

MOST_CASES = 10**7
"""Most cases of a sweep."""

MOST_HYPERCUBE = 10**6
"""Most cases of a Latin hypercube, which is drawn at once."""

_EDGE = 2.0**-40
"""Shares that are drawn stay this far from 0 and 1, where normal distributions are infinite."""

Values = dict[str, Any]


def count_of(design: Design, drawn: int, tried: Mapping[str, list[Any]], size: int) -> int:
    """Return the number of cases.

    Args:
        drawn: cases that are asked for; points, of `sobol-indices`; nothing to a grid.
        tried: values of a grid.
        size: how many parameters vary.
    """
    if design == "grid":
        return math.prod(map(len, tried.values()))
    return drawn * (size + 2) if design == "sobol-indices" else drawn


def grids(vary: Mapping[str, Varied], known: Mapping[str, Parameter]) -> dict[str, list[Any]]:
    """Return the values that a grid tries of each parameter; of whole numbers none twice."""
    return {name: list(dict.fromkeys(map(known[name].drawn, varied.grid(name)))) for name, varied in vary.items()}


def of_grid(tried: Mapping[str, list[Any]], first: int, last: int) -> list[Values]:
    """Return the values of cases first to last - 1 of a grid."""
    made = []
    for case in range(first, last):
        rest, values = case, dict[str, Any]()
        for name in reversed(list(tried)):
            rest, place = divmod(rest, len(tried[name]))
            values[name] = tried[name][place]
        made.append({name: values[name] for name in tried})
    return made


def of_points(vary: Mapping[str, Varied], known: Mapping[str, Parameter], shares: Array) -> list[Values]:
    """Return the values at points of the unit cube, shape (n, parameters)."""
    columns = [[known[name].drawn(x) for x in each.at(shares[:, k])] for k, (name, each) in enumerate(vary.items())]
    return [dict(zip(vary, row, strict=True)) for row in zip(*columns, strict=True)]


def points(design: Design, drawn: int, size: int, seed: int, first: int, last: int) -> Array:
    """Return points first to last - 1 of the unit cube, shape (last - first, size), the same in any pieces."""
    from scipy.stats import qmc

    if design == "latin-hypercube":
        found = _hypercube(drawn, size, seed)[first:last]
    else:
        engine = qmc.Sobol(size, scramble=True, seed=seed)
        if first:
            engine.fast_forward(first)
        with warnings.catch_warnings():  # it would rather have a power of two, which pieces are not
            warnings.simplefilter("ignore", UserWarning)
            found = engine.random(last - first)
    return np.clip(found, _EDGE, 1 - _EDGE)


@lru_cache(maxsize=1)
def _hypercube(drawn: int, size: int, seed: int) -> Array:
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(size, seed=np.random.default_rng(seed)).random(drawn))


def of_indices(
    vary: Mapping[str, Varied], known: Mapping[str, Parameter], drawn: int, seed: int, first: int, last: int
) -> list[Values]:
    """Return the values of cases first to last - 1 of `sobol-indices`, see `roles`."""
    size, each = len(vary), len(vary) + 2
    low, high = first // each, -(-last // each)
    both = points("sobol-indices", drawn, 2 * size, seed, low, high)
    made: list[Values] = []
    a, b = of_points(vary, known, both[:, :size]), of_points(vary, known, both[:, size:])
    for one, other in zip(a, b, strict=True):
        made += [one, other, *(one | {name: other[name]} for name in vary)]
    return made[first - low * each : last - low * each]


def roles(names: list[str], first: int, last: int) -> tuple[list[int], list[str]]:
    """Return what cases first to last - 1 of `sobol-indices` are: numbers of points, and matrices.

    A, B, or AB:NAME, which is A but for the parameter of this name, which is from B.
    """
    matrices = ["A", "B", *(f"AB:{name}" for name in names)]
    both = [divmod(case, len(matrices)) for case in range(first, last)]
    return [point for point, _ in both], [matrices[place] for _, place in both]

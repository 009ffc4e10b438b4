"""Where the searches of a fit start: from what the arm has, and from draws of priors and bounds."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from contarm_sim.identify.shared import Shared, prior_of
from contarm_sim.kinematics.arrays import Array


def starts_of(every: Shared, count: int, seed: int = 0) -> Array:
    """Return where searches start, shape (count, P): the start itself, then a Latin hypercube.

    A parameter with a prior is drawn from it; one with two bounds, evenly between them; any other about its start, with
    its typical change as standard deviation.
    """
    generator, size = np.random.default_rng(seed), len(every.free)
    strata = np.array([generator.permutation(count - 1) for _ in range(size)]).T if count > 1 else np.zeros((0, size))
    levels = (strata + generator.uniform(size=strata.shape)) / max(count - 1, 1)
    drawn = every.start + spreads(every) * ndtri(np.clip(levels, 1e-9, 1 - 1e-9))
    for place, one in enumerate(every.free):
        if one.sd is not None:
            drawn[:, place] += prior_of(every, place)[0] - every.start[place]
        elif _bounded(every, place):
            low, high = every.low[place], every.high[place]
            drawn[:, place] = low + (high - low) * levels[:, place]
    return np.clip(np.vstack([every.start, drawn]), every.low, every.high)


def spreads(every: Shared) -> Array:
    """Return how far the best vector may be from the start, shape (P,): a standard deviation."""
    out = every.typical.copy()
    for place, one in enumerate(every.free):
        if one.sd is not None:
            out[place] = prior_of(every, place)[1]
        elif _bounded(every, place):
            out[place] = 0.3 * (every.high[place] - every.low[place])
    return out


def _bounded(every: Shared, place: int) -> bool:
    one = every.free[place]
    return one.low is not None and one.high is not None and (one.low > 0 or not every.logarithmic[place])

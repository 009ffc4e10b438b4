"""Where the searches of a fit start: from what the arm has, and from draws of priors and bounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import ndtri

from contarm_sim.identify.search.residuals import Problem
from contarm_sim.identify.search.seeing import POOR, POOR_LENGTH, scatter
from contarm_sim.identify.search.shared import Shared, prior_of
from contarm_sim.kinematics.arrays import Array

SLACKS = np.linspace(-0.25, 0.75, 13)
"""Slacks of all tendons together that are tried, over the longest winding of a recording."""

FLAT = 1e-3
"""Change of the cost from one of them to the next, as a share of the end's, below which all tendons are taut."""

AWAY = 0.05
"""How far from its end a search begins anew at least, over the longest winding."""


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


def other_slack(problem: Problem, vector: Array, errors: Array) -> list[Array]:
    """Return where to search again if the slacks of windings ended in a wrong valley: one start, shape (P,), or none.

    While all tendons are taut, their common slack changes next to nothing: from there a search cannot tell that they
    were slack. So all slacks without a prior are shifted together, in one population, from where the search began and
    from where it ended. A shift that predicts better than the end is where to begin anew. So is the best other shift
    after a search that explains little, or that ended where all tendons are taut. Slacks that the start did not show
    may move from then on.

    Args:
        problem: where the search was.
        vector: its end, shape (P,).
        errors: there [m], shape (M,).
    """
    every = problem.every
    slack = np.array([one.name.startswith("actuation.slack") and one.sd is None for one in every.free])
    wound = [
        np.abs(replace(one.rig.actuation, slack=()).values(one.commands)).max(initial=0.0)
        for one in problem.recordings
        if one.rig.actuation.drive == "windings"
    ]
    if not slack.any() or not wound:
        return []
    shifted = np.repeat([vector, every.start], len(SLACKS), axis=0)
    shifted[:, slack] += max(wound) * np.tile(SLACKS, 2)[:, None]
    shifted = np.clip(shifted, every.low, every.high)
    costs = np.array([problem.cost(*both) for both in zip(problem.errors(shifted), shifted, strict=True)])
    now, rms = problem.cost(errors, vector), float(np.sqrt((problem.filled(errors) ** 2).mean()))
    little = rms > max(POOR * scatter(problem.recordings), POOR_LENGTH * problem.length) / np.sqrt(3)
    same = np.abs(np.diff(costs.reshape(2, -1), axis=1)) < FLAT * now
    taut = np.pad(same, ((0, 0), (1, 0))) | np.pad(same, ((0, 0), (0, 1)))
    away = np.abs((shifted - vector)[:, slack].mean(axis=1)) >= AWAY * max(wound)
    costs[taut.ravel() | ~away] = np.inf
    if np.isinf(costs).all() or not (costs.min() < now or little or taut[0, int(np.abs(SLACKS).argmin())]):
        return []
    problem.active = problem.active | slack
    return [shifted[int(costs.argmin())]]


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

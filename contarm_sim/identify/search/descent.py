"""The search of a fit from one start: least squares, or an evolution strategy that least squares finish."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from contarm_sim.errors import MissingError
from contarm_sim.identify.judgement.intervals import noise_of
from contarm_sim.identify.search.losses import THRESHOLD
from contarm_sim.identify.search.residuals import LEAST_NOISE, Problem
from contarm_sim.identify.search.starts import spreads
from contarm_sim.kinematics.arrays import Array

Method = Literal["least-squares", "cma"]
METHODS: tuple[Method, ...] = get_args(Method)

STOPPED = "stopped early"
"""What the message of a fit begins with that Ctrl-C ended."""

ROUNDS = 6
"""Most times that the noise is estimated anew."""

SETTLED = 0.05
"""Change of the noise, as a share, at which it is left as it is."""

COARSE, FINE = 1e-2, 1e-3
"""Change of the cost at which a search ends: as a share, before the noise is settled; at last, as it is.

The cost is half the number of residuals in the end; one that is higher by 0.5 is one standard deviation off.
"""

INSIDE = 1e-3
"""How far inside of its bounds a search begins, over a parameter's typical change."""

MOST = 60
"""Most steps of one search by least squares."""

GENERATIONS = 200
"""Most populations of an evolution strategy."""


@dataclass(frozen=True)
class Found:
    """Where a search ended.

    Attributes:
        vector: of all parameters, shape (P,).
        errors: there [m], shape (M,).
        noise: of one coordinate [m].
        converged: whether it ended by itself.
        message: of the solver.
    """

    vector: Array
    errors: Array
    noise: float
    converged: bool
    message: str


def searched(problem: Problem, start: Array, noise: float | None, method: Method, seed: int) -> Found:
    """Return the best vector found from a start, shape (P,).

    Args:
        problem: with the parameters that move.
        start: where to begin.
        noise: of one coordinate [m]; None: estimated, and anew after each search.
        method: `cma` searches a population before least squares do.
        seed: of that population.

    Raises:
        MissingError: `cma` is not installed.
    """
    problem.base = start.copy()
    moved = start[problem.active]
    renewed(problem, moved, noise)
    if method == "cma":
        moved = _evolved(problem, moved, seed)
        renewed(problem, moved, noise)
    indifferent = problem.loss == "linear" and not any(one.sd is not None for one in problem.every.free)
    settled = noise is not None or indifferent
    for turn in range(ROUNDS):
        before, last = problem.noise, settled or turn == ROUNDS - 1
        moved, converged, message = _least_squares(problem, moved, last)
        errors = renewed(problem, moved, noise)
        steady = noise is not None or indifferent or abs(problem.noise - before) <= SETTLED * before
        if last and steady:
            break
        settled = steady  # a coarse search may end before it has left a bound: the fine one tells
    return Found(problem.full(moved), errors, problem.noise, converged, message)


def renewed(problem: Problem, moved: Array, noise: float | None) -> Array:
    """Estimate the noise where a search stands, unless it is given; costs are then of that noise.

    Returns:
        errors there [m], shape (M,).
    """
    vector = problem.full(moved)
    errors = problem.errors(vector[None])[0]
    if noise is None:
        noise = noise_of(problem.filled(errors), int(problem.active.sum()), problem.loss)
    problem.noise = max(noise, LEAST_NOISE * problem.length)
    problem.best = None
    problem.note(vector, errors)
    return errors


def _least_squares(problem: Problem, moved: Array, settled: bool) -> tuple[Array, bool, str]:
    from scipy.optimize import least_squares

    tolerance = max(FINE / (0.5 * problem.size), 1e-9) if settled else COARSE
    low, high = problem.every.low[problem.active], problem.every.high[problem.active]
    # from clearly inside: SciPy would begin at 1e-10 of a bound, where a mass of 0 is none that the engine takes
    inside = np.minimum(INSIDE * problem.every.typical[problem.active], 0.25 * (high - low))
    found = least_squares(
        problem.residuals, np.clip(moved, low + inside, high - inside), problem.jacobian, (low, high), x_scale="jac",
        loss=problem.scipy_loss, f_scale=THRESHOLD, ftol=tolerance, xtol=1e-9, gtol=1e-12, max_nfev=MOST,
    )  # fmt: skip
    assert problem.best is not None
    return problem.best[0][problem.active], bool(found.success), str(found.message)


def _evolved(problem: Problem, moved: Array, seed: int) -> Array:
    try:
        from cma import CMAEvolutionStrategy
    except ImportError:
        raise MissingError("cma", "fit") from None
    typical = spreads(problem.every)[problem.active]
    low = (problem.every.low[problem.active] - moved) / typical
    high = (problem.every.high[problem.active] - moved) / typical
    options = {
        "seed": seed + 1, "bounds": [low.tolist(), high.tolist()], "verbose": -9, "tolfun": 1e-4, "tolx": 1e-4,
        "maxiter": GENERATIONS,
    }  # fmt: skip
    strategy = CMAEvolutionStrategy(np.zeros(len(moved)), 1.0, options)
    while not strategy.stop():
        asked = strategy.ask()
        vectors = problem.full(moved + typical * np.array([strategy.mean, *asked]))
        errors = problem.errors(np.clip(vectors, problem.every.low, problem.every.high))
        costs = [problem.cost(one, vector) for one, vector in zip(errors, vectors, strict=True)]
        best = int(np.argmin(costs))
        problem.note(vectors[best], errors[best])
        strategy.tell(asked, costs[1:])
    assert problem.best is not None
    return problem.best[0][problem.active]

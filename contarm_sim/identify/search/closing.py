"""What a fit comes to once its search has ended: what is held where data do not determine it, and the intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from contarm_sim.identify.fitted import Parameter
from contarm_sim.identify.judgement.judge import Judgement, judge
from contarm_sim.identify.search.descent import STOPPED, Found, searched
from contarm_sim.identify.search.losses import THRESHOLD
from contarm_sim.identify.search.residuals import Problem
from contarm_sim.identify.search.seeing import cannot_see, moves
from contarm_sim.kinematics.arrays import Array

ROUNDING = 1e-5
"""Relative error of derivatives from both sides."""


CLEARLY = 2.0
"""Rise of the cost, half a sum of squares over the noise, that data clearly see: of two standard deviations."""

NEARBY = "near these values: larger steps change the errors"
"""Said of a combination that the data do not determine where the fit ended."""


def closed(
    problem: Problem, found: Found, noise: float | None, bootstrap: int, seed: int
) -> tuple[Found, Judgement]:  # fmt: skip
    """Return where the fit ends, and what became of the parameters.

    What the data do not determine is held at its start, and the search goes on for the others. After Ctrl-C values are
    as they were found, and nothing is said of how well they are known.

    Args:
        problem: where the search was.
        found: its end.
        noise: as of the fit.
        bootstrap: resamplings of blocks.
        seed: of the draws.
    """
    if not found.message.startswith(STOPPED):
        try:
            return _settled(problem, found, noise, bootstrap, seed)
        except KeyboardInterrupt:
            found = replace(found, converged=False, message=f"{STOPPED}, before the intervals")
    return found, _unjudged(problem, found.vector)


def _settled(
    problem: Problem, found: Found, noise: float | None, bootstrap: int, seed: int
) -> tuple[Found, Judgement]:  # fmt: skip
    started, held = problem.active, tuple[int, ...]()
    slopes = _slopes(problem, found)
    if (moves(problem, slopes) & ~started).any():  # seen from here, though not from the start
        problem.phase, problem.of, problem.active = "search", None, moves(problem, slopes)
        found = _again(problem, found, found.vector, noise, seed)
        slopes = _slopes(problem, found)
    judged = _judged(problem, found, slopes, held, bootstrap, seed)
    while len(judged.hold) > len(held):  # each search may end where less is seen
        problem.phase, problem.of, held = "search without what is not determined", None, judged.hold
        problem.active = np.ones(len(found.vector), dtype=bool)
        problem.active[list(held)] = False
        if problem.active.any():
            found = _again(problem, found, judged.vector, problem.noise, seed)
        else:
            found = replace(found, vector=judged.vector, errors=problem.errors(judged.vector[None])[0])
        judged = _judged(problem, found, _slopes(problem, found), held, bootstrap, seed)
    return found, _near(problem, found, judged)


def _near(problem: Problem, found: Found, judged: Judgement) -> Judgement:
    """Say of which combinations a plausible step changes the errors, though small ones do not."""
    steps = np.concatenate([judged.open.T, -judged.open.T])
    vectors = np.clip(found.vector + steps, problem.every.low, problem.every.high)
    if not len(vectors):
        return judged
    now = problem.cost(found.errors, found.vector)
    costs = np.array([problem.cost(*both) for both in zip(problem.errors(vectors), vectors, strict=True)])
    ends = costs.reshape(2, -1).min(axis=0) > now + CLEARLY
    told = [replace(one, said=f"{one.said} ({NEARBY})" if end else one.said)
            for one, end in zip(judged.undetermined, ends.tolist(), strict=True)]  # fmt: skip
    return replace(judged, undetermined=tuple(told))


def _unjudged(problem: Problem, vector: Array) -> Judgement:
    """Return values as a search that was stopped left them."""
    every, count, nan = problem.every, len(vector), float("nan")
    rows = zip(every.free, every.units, every.start_values.tolist(), every.of_vector(vector).tolist(), strict=True)
    told = tuple(Parameter(*row, nan, nan, nan, nan, nan, "stopped early") for row in rows)
    unknown = np.full((count, count), nan)
    return Judgement(
        told, (), np.zeros((count, 0)), (), vector, unknown, unknown, unknown[0], problem.noise, "plain", unknown[0]
    )


def _again(problem: Problem, found: Found, start: Array, noise: float | None, seed: int) -> Found:
    """Search once more from where a search ended."""
    again = searched(problem, start, noise, "least-squares", seed)
    return replace(again, converged=found.converged and again.converged, message=found.message)


def _slopes(problem: Problem, found: Found) -> Array:
    """Return derivatives of errors by all parameters from both sides, shape (M, P)."""
    problem.base, problem.active = found.vector, np.ones(len(found.vector), dtype=bool)
    problem.phase, problem.of = "intervals", problem.evaluations + 1 + 2 * len(found.vector)
    return problem.slopes(found.vector, central=True)


def _judged(
    problem: Problem, found: Found, slopes: Array, hold: Sequence[int], bootstrap: int, seed: int
) -> Judgement:  # fmt: skip
    every, rows = problem.every, np.isfinite(found.errors)
    judged = judge(
        every.free, every.units, every.logarithmic, every.start, (every.low, every.high), found.vector,
        found.errors[rows], slopes[rows], problem.blocks[rows], noise=found.noise, loss=problem.loss,
        loss_scale=THRESHOLD, rounding=ROUNDING, held=tuple(hold), boot=bootstrap, seed=seed,
    )  # fmt: skip
    told = []
    for one, start in zip(judged.parameters, every.start_values.tolist(), strict=True):
        why = cannot_see(one.name, problem.recordings) if one.status == "not seen" else ""
        told.append(replace(one, start=start, said=why or one.said))
    return replace(judged, parameters=tuple(told))

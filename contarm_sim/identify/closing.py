"""What a fit comes to once its search has ended: what is held where data do not determine it, and the intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from contarm_sim.identify.judge import Judgement, judge
from contarm_sim.identify.losses import THRESHOLD
from contarm_sim.identify.residuals import Problem
from contarm_sim.identify.search import STOPPED, Found, searched
from contarm_sim.identify.seeing import cannot_see, moves
from contarm_sim.kinematics.arrays import Array

ROUNDING = 1e-5
"""Relative error of derivatives from both sides."""

ROUNDING_ONE_SIDED = 1e-3
"""Of those from one side, where the fit was stopped before the others."""


def closed(
    problem: Problem, found: Found, noise: float | None, bootstrap: int, seed: int
) -> tuple[Found, Judgement]:  # fmt: skip
    """Return where the fit ends, and what became of the parameters.

    What the data do not determine is held at its start, and the search goes on for the others. Ctrl-C leaves all as it
    is, and the last derivatives serve.

    Args:
        problem: where the search was.
        found: its end.
        noise: as of the fit.
        bootstrap: resamplings of blocks.
        seed: of the draws.
    """
    if found.converged or not found.message.startswith(STOPPED):
        try:
            return _settled(problem, found, noise, bootstrap, seed)
        except KeyboardInterrupt:
            found = replace(found, converged=False, message=f"{STOPPED}, before the intervals")
    slopes = problem.latest if problem.latest is not None else np.zeros((problem.size, len(found.vector)))
    return found, replace(_judged(problem, found, slopes, (), 0, seed, ROUNDING_ONE_SIDED), vector=found.vector)


def _settled(
    problem: Problem, found: Found, noise: float | None, bootstrap: int, seed: int
) -> tuple[Found, Judgement]:  # fmt: skip
    started = problem.active
    slopes = _slopes(problem, found)
    if (moves(problem, slopes) & ~started).any():  # seen from here, though not from the start
        problem.phase, problem.of, problem.active = "search", None, moves(problem, slopes)
        found = _again(problem, found, found.vector, noise, seed)
        slopes = _slopes(problem, found)
    judged = _judged(problem, found, slopes, (), bootstrap, seed)
    if judged.hold:
        problem.phase, problem.of = "search without what is not determined", None
        problem.active = np.ones(len(found.vector), dtype=bool)
        problem.active[list(judged.hold)] = False
        if problem.active.any():
            found = _again(problem, found, judged.vector, problem.noise, seed)
        else:
            found = replace(found, vector=judged.vector, errors=problem.errors(judged.vector[None])[0])
        judged = _judged(problem, found, _slopes(problem, found), judged.hold, bootstrap, seed)
        if len(judged.hold) and not np.array_equal(judged.vector, found.vector):
            found = replace(found, vector=judged.vector)
    return found, judged


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
    problem: Problem, found: Found, slopes: Array, hold: Sequence[int], bootstrap: int, seed: int,
    rounding: float = ROUNDING,
) -> Judgement:  # fmt: skip
    every, rows = problem.every, np.isfinite(found.errors)
    judged = judge(
        every.free, every.units, every.logarithmic, every.start, (every.low, every.high), found.vector,
        found.errors[rows], slopes[rows], problem.blocks[rows], noise=found.noise, loss=problem.loss,
        loss_scale=THRESHOLD, rounding=rounding, held=tuple(hold), boot=bootstrap, seed=seed,
    )  # fmt: skip
    told = []
    for one, start in zip(judged.parameters, every.start_values.tolist(), strict=True):
        why = cannot_see(one.name, problem.recordings) if one.status == "not seen" else ""
        told.append(replace(one, start=start, said=why or one.said))
    return replace(judged, parameters=tuple(told))

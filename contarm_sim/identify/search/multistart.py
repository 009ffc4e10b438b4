"""Searches from several starts, the best of them first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from contarm_sim.errors import ContarmError, InputError, MissingError
from contarm_sim.identify.search.descent import STOPPED, Found, Method, renewed, searched
from contarm_sim.identify.search.residuals import Problem
from contarm_sim.identify.search.starts import other_slack
from contarm_sim.kinematics.arrays import Array


def best_of(
    problem: Problem, starts: Array, noise: float | None, method: Method, seed: int
) -> tuple[Found, tuple[float, ...]]:
    """Return the best of the searches from starts, shape (S, P), and the costs of each, the best first.

    One that fails costs inf, and the message tells why; Ctrl-C ends them, and what they found until then is returned.
    Windings are searched once more from another slack of all tendons where that promises more, see `other_slack`.

    Raises:
        InputError: all fail.
        MissingError: as `searched`.
    """
    every, failures, stopped = list[Found](), list[str](), False
    mine, queue, number = problem.every.start, list(starts), 0
    while queue and not stopped:
        begin, number = np.where(problem.active, queue.pop(0), mine), number + 1
        problem.phase = "search" if number == len(starts) == 1 else _called(number, len(starts))
        try:
            if np.isnan(problem.errors(begin[None])).all():
                failures.append(f"start {number}: no pose at any sample")
            else:
                every.append(searched(problem, begin, noise, method, seed + number - 1))
            if number == len(starts) and every:
                best = _best(problem, every)[0]
                problem.noise = best.noise
                queue += other_slack(problem, best.vector, best.errors)
        except KeyboardInterrupt:
            stopped = True
        except MissingError:
            raise
        except (ContarmError, ValueError, np.linalg.LinAlgError) as error:
            failures.append(f"start {number}: {error}")
    if stopped:
        vector = mine if problem.best is None else problem.best[0]
        errors = renewed(problem, vector[problem.active], noise)
        every.append(Found(vector, errors, problem.noise, False, STOPPED))
    if not every:
        raise InputError("start", f"none of {len(starts)} led anywhere", f"others: {failures[0]}")
    best, costs = _best(problem, every)
    problem.noise = best.noise
    end = f"{STOPPED}, in {_called(number, len(starts))}"
    told = [end if stopped else best.message.rstrip("."), *failures]
    if failures:
        told.insert(1, f"{len(failures)} of {len(starts)} starts failed")
    best = replace(best, converged=best.converged and not stopped, message="; ".join(told))
    return best, (*sorted(costs), *[np.inf] * len(failures))


def _best(problem: Problem, every: list[Found]) -> tuple[Found, list[float]]:
    """Return the best of searches, and the costs of all, by the least noise of any."""
    common = min(one.noise for one in every)
    costs = [problem.cost(one.errors, one.vector, common) for one in every]
    return every[int(np.argmin(costs))], costs


def _called(number: int, count: int) -> str:
    return f"start {number} of {count}" if number <= count else "a start with other slack"

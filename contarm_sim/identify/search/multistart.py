"""Searches from several starts, the best of them first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from contarm_sim.errors import ContarmError, InputError, MissingError
from contarm_sim.identify.search.descent import STOPPED, Found, Method, renewed, searched
from contarm_sim.identify.search.residuals import Problem
from contarm_sim.kinematics.arrays import Array


def best_of(
    problem: Problem, starts: Array, noise: float | None, method: Method, seed: int
) -> tuple[Found, tuple[float, ...]]:
    """Return the best of the searches from starts, shape (S, P), and the costs of each, the best first.

    One that fails costs inf, and the message tells why; Ctrl-C ends them, and what they found until then is returned.

    Raises:
        InputError: all fail.
        MissingError: as `searched`.
    """
    every, failures, stopped = list[Found](), list[str](), False
    mine = problem.every.start
    for place, start in enumerate(starts):
        problem.phase = "search" if len(starts) == 1 else f"start {place + 1} of {len(starts)}"
        begin = np.where(problem.active, start, mine)
        try:
            if np.isnan(problem.errors(begin[None])).all():
                failures.append(f"start {place + 1}: no pose at any sample")
                continue
            every.append(searched(problem, begin, noise, method, seed + place))
        except KeyboardInterrupt:
            stopped = True
        except MissingError:
            raise
        except (ContarmError, ValueError, np.linalg.LinAlgError) as error:
            failures.append(f"start {place + 1}: {error}")
        if stopped:
            vector = mine if problem.best is None else problem.best[0]
            errors = renewed(problem, vector[problem.active], noise)
            every.append(Found(vector, errors, problem.noise, False, STOPPED))
            break
    if not every:
        raise InputError("start", f"none of {len(starts)} led anywhere", f"others: {failures[0]}")
    common = min(one.noise for one in every)
    costs = [problem.cost(one.errors, one.vector, common) for one in every]
    best = every[int(np.argmin(costs))]
    problem.noise = best.noise
    end = f"{STOPPED}, in start {len(every) + len(failures)} of {len(starts)}"
    told = [end if stopped else best.message.rstrip("."), *failures]
    if failures:
        told.insert(1, f"{len(failures)} of {len(starts)} starts failed")
    best = replace(best, converged=best.converged and not stopped, message="; ".join(told))
    return best, (*sorted(costs), *[np.inf] * len(failures))

"""Fits the parameters of an arm, and of what stands around it, to recordings."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import ContarmError, InputError, MissingError
from contarm_sim.identify.fitted import Fit, Left, Parameter, Status
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.losses import LOSSES, Loss
from contarm_sim.identify.predict import Predictor
from contarm_sim.identify.predictors import Memory, predictor_of
from contarm_sim.identify.recording import Recording
from contarm_sim.identify.residuals import Problem, Progress
from contarm_sim.identify.search import METHODS, Found, Method, searched
from contarm_sim.identify.shared import shared
from contarm_sim.identify.split import held_out_of
from contarm_sim.identify.starts import starts_of
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number, check_count

UNSEEN = 1e-6
"""Effect of a parameter's typical change on any coordinate, over the length of the arm, below which it is not seen."""


def fit(
    arm: Arm,
    recordings: Recording | Sequence[Recording],
    free: Sequence[Free | str],
    *,
    held_out: Any = (),
    loss: Loss = "soft_l1",
    noise: float | None = None,
    starts: int = 1,
    method: Method = "least-squares",
    bootstrap: int = 0,
    memory: Memory = "auto",
    threads: int = 0,
    seed: int = 0,
    on_progress: Callable[[Progress], None] | None = None,
    predictors: Sequence[Predictor] | None = None,
) -> Fit:
    """Return the arm and the rigs that predict the markers of recordings best.

    Least sum of losses of residuals over the noise, and of squares of what priors are off by. The noise of a coordinate
    is estimated from the residuals themselves, by their median, until it settles.

    Args:
        arm: that the search starts from.
        recordings: of that arm; they share the parameters, those of a rig too: each recording's own rig has them.
        free: parameters that may change, see `freedom`.
        held_out: samples that are only predicted: names of blocks (`*` stands for anything), a fraction taken as whole
            blocks, or masks.
        loss: `linear`, `soft_l1`, `huber` or `cauchy`.
        noise: standard deviation of a coordinate [m], where it is known.
        starts: searches: one from the arm as it is, the others from draws of priors and bounds.
        method: `least-squares`, or `cma` (an evolution strategy) where there are many valleys; least squares finish.
        bootstrap: resamplings of blocks for a second kind of intervals.
        memory: whether poses at rest remember what came before, see `predictors`.
        threads: that share the work; 0: one a processor.
        seed: of all draws.
        on_progress: told how far it is.
        predictors: one for each recording, instead of those of `predictor_of`.

    Raises:
        InputError: arguments that do not fit together, more free parameters than data, none that the recordings see, or
            a start at which the arm has no pose at all.
        MissingError: `cma` is not installed.
    """
    began = time.perf_counter()
    several = (recordings,) if isinstance(recordings, Recording) else tuple(recordings)
    _check(several, loss, noise, starts, method, bootstrap, threads)
    every = shared(arm, several, free)
    held = held_out_of(several, held_out, seed)
    if predictors is None:
        predictors = [predictor_of(one, arm, names=every.names, memory=memory, threads=threads) for one in several]
    problem = Problem(every, several, held, predictors, loss, on_progress)
    if len(every.free) > problem.size:
        said = f"at most {problem.size}, as many as there are coordinates to fit to"
        raise InputError("free", f"{len(every.free)} parameters", said)
    _look(problem)
    found, costs, messages = _best(problem, starts_of(every, starts, seed), noise, method, seed)
    return _result(problem, found, held, costs, messages, method, bootstrap, seed, began)


def _check(
    recordings: Sequence[Recording], loss: str, noise: float | None, starts: int, method: str, bootstrap: int,
    threads: int,
) -> None:  # fmt: skip
    if not recordings:
        raise InputError("recordings", "none", "one or more")
    if loss not in LOSSES:
        raise InputError("loss", repr(loss), ", ".join(LOSSES))
    if method not in METHODS:
        raise InputError("method", repr(method), ", ".join(METHODS))
    if noise is not None and not 0 < as_number(noise) < np.inf:
        raise InputError("noise", noise, "a length above 0 in metres, or nothing: it is estimated")
    check_count("starts", starts, 1)
    check_count("bootstrap", bootstrap, 0)
    check_count("threads", threads, 0)


def _look(problem: Problem) -> None:
    """Leave alone what the recordings do not see at the start.

    Raises:
        InputError: they see nothing.
    """
    every = problem.every
    errors = problem.errors(every.start[None])[0]
    if np.isnan(errors).all():
        raise InputError("arm", "without a pose at any sample", "a start that has some: another stiffness or slack")
    problem.active = seen(problem, every.start)
    if not problem.active.any():
        sentences = dict.fromkeys(cannot_see(name, problem.recordings) for name in every.names)
        why = "; ".join(one for one in sentences if one) or "its markers do not move with them"
        raise InputError("free", ", ".join(every.names), f"parameters that the recording sees ({why})")


def seen(problem: Problem, vector: Array) -> NDArray[np.bool_]:
    """Return which parameters move any marker, shape (P,)."""
    problem.base, problem.active = vector, np.ones(len(vector), dtype=bool)
    effect = np.abs(problem.slopes(vector)).max(axis=0) * problem.every.typical
    return np.asarray(effect > UNSEEN * problem.length)


def cannot_see(name: str, recordings: Sequence[Recording]) -> str:
    """Return why recordings of this kind do not see a parameter, or nothing."""
    if all(one.kind == "static" for one in recordings):
        if "damping" in name:
            return "an arm at rest does not show its damping"
        if name.split(".")[-1] in ("mass", "payload", "gravity"):
            return "an arm at rest shows its weight alone, and only where gravity bends it"
    if name.startswith("actuation.") and all(one.rig.actuation.drive == "none" for one in recordings):
        return "no channel drives anything"
    return ""


def _best(
    problem: Problem, starts: Array, noise: float | None, method: Method, seed: int
) -> tuple[Found, tuple[float, ...], str]:
    """Return the best of all searches, the costs of each, the best first, and what is to be said."""
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
            errors = problem.errors(vector[None])[0]
            every.append(Found(vector, errors, problem.noise, False, "stopped early"))
            break
    if not every:
        raise InputError("start", f"none of {len(starts)} led anywhere", f"others: {failures[0]}")
    common = min(one.noise for one in every)
    costs = [problem.cost(one.errors, one.vector, common) for one in every]
    best = every[int(np.argmin(costs))]
    problem.noise = best.noise
    told = [
        best.message.rstrip("."),
        *([f"{len(failures)} of {len(starts)} starts failed"] if failures else []),
        *failures,
    ]
    if stopped and best.message != "stopped early":
        told.insert(0, f"stopped early, in start {len(every) + len(failures)} of {len(starts)}")
    if stopped:
        best = Found(best.vector, best.errors, best.noise, False, best.message)
    return best, (*sorted(costs), *[np.inf] * len(failures)), "; ".join(told)


def _result(
    problem: Problem, found: Found, held: Sequence[NDArray[np.bool_]], costs: tuple[float, ...], message: str,
    method: str, bootstrap: int, seed: int, began: float,
) -> Fit:  # fmt: skip
    every = problem.every
    problem.phase = "intervals"
    arm, rigs = every.applied(found.vector)
    left = _left(problem, found.vector, rigs, held)
    start, values = every.of_vector(every.start), every.of_vector(found.vector)
    parameters, nan = [], float("nan")
    for place, one in enumerate(every.free):
        was_seen = bool(problem.active[place])
        said = "" if was_seen else cannot_see(one.name, problem.recordings)
        value = float(values[place]) if was_seen else nan
        state: Status = "determined" if was_seen else "not seen"
        unknown = (nan,) * 5
        parameters.append(Parameter(one, every.units[place], float(start[place]), value, *unknown, state, said))
    size = len(every.free)
    return Fit(
        arm, rigs, tuple(parameters), (), np.full((size, size), np.nan), np.full(size, np.nan), left, found.noise,
        costs, found.converged, problem.evaluations, time.perf_counter() - began, method, message,
    )  # fmt: skip


def _left(problem: Problem, vector: Array, rigs: Sequence[Any], held: Sequence[NDArray[np.bool_]]) -> tuple[Left, ...]:
    predicted = problem.predicted(vector[None])
    rows = zip(problem.recordings, rigs, predicted, held, strict=True)
    return tuple(Left(one.in_rig(rig), found[0], out) for one, rig, found, out in rows)

"""Fits the parameters of an arm, and of what stands around it, to recordings."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from contarm_sim.errors import InputError, expect
from contarm_sim.identify.fitted import Fit, Left
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.prediction.base import Predictor
from contarm_sim.identify.prediction.choice import Memory, predictor_of
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.search.closing import closed
from contarm_sim.identify.search.descent import METHODS, Method
from contarm_sim.identify.search.losses import LOSSES, Loss
from contarm_sim.identify.search.multistart import best_of
from contarm_sim.identify.search.residuals import Problem, Progress
from contarm_sim.identify.search.seeing import cannot_see, moves
from contarm_sim.identify.search.shared import shared
from contarm_sim.identify.search.split import held_out_of
from contarm_sim.identify.search.starts import starts_of
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number, check_count


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
    expect("arm", arm, Arm)
    arm.refuse_objects("arms are fitted")
    several = (recordings,) if isinstance(recordings, Recording) else tuple(recordings)
    _check(several, loss, noise, starts, method, bootstrap, threads)
    if predictors is not None and len(predictors) != len(several):
        raise InputError("predictors", f"{len(predictors)}", f"{len(several)}, one for each recording")
    every = shared(arm, several, free)
    held = held_out_of(several, held_out, seed)
    if predictors is None:
        predictors = [predictor_of(one, arm, names=every.names, memory=memory, threads=threads) for one in several]
    several = tuple(one.recording for one in predictors)  # a motion is followed from its release on
    problem = Problem(every, several, held, predictors, loss, on_progress)
    if len(every.free) > problem.size:
        said = f"at most {problem.size}, as many as there are coordinates to fit to"
        raise InputError("free", f"{len(every.free)} parameters", said)
    _look(problem)
    found, costs = best_of(problem, starts_of(every, starts, seed), noise, method, seed)
    found, judged = closed(problem, found, noise, bootstrap, seed)
    done, (fitted, rigs) = judged.parameters, every.applied(found.vector)
    predicted = problem.predicted(found.vector[None])
    rows = zip(several, rigs, predicted, held, strict=True)
    return Fit(
        fitted, rigs, done, judged.undetermined, judged.correlation, judged.singular_values,
        tuple(Left(one.in_rig(rig), where[0], out) for one, rig, where, out in rows), found.noise, costs,
        found.converged, problem.evaluations, time.perf_counter() - began, method, found.message,
    )  # fmt: skip


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
    problem.note(every.start, errors)
    problem.active = moves(problem, problem.slopes(every.start))
    if not problem.active.any():
        sentences = dict.fromkeys(cannot_see(name, problem.recordings) for name in every.names)
        why = "; ".join(one for one in sentences if one) or "its markers do not move with them"
        if sum(map(len, problem.recordings)) == 1:
            why += "; it is one sample alone"
        raise InputError("free", ", ".join(every.names), f"parameters that the recording sees ({why})")

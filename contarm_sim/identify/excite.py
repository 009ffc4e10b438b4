"""What to command next: the patterns among candidates whose measurement would tell most of the free parameters.

A pattern's information is J^T J / noise^2, J the derivatives of the predicted markers by the parameters at the arm as
it is known. Patterns are chosen one after the other, then exchanged as long as that helps (Fedorov 1972), so that the
determinant of the information is as large as it can be (D) or the sum of the variances as small (A). It is counted on
top of what a recording and priors tell already, and in steps of what each parameter may plausibly be wrong by
(`identifiability.plausible`), so that a direction that no candidate tells does not hide the others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.errors import InputError, expect
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.judgement.identifiability import LEAK, plausible, prior_precision
from contarm_sim.identify.prediction.base import Predictor
from contarm_sim.identify.prediction.choice import predictor_of
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.identify.recordings.synthetic import random_windings
from contarm_sim.identify.search.residuals import Problem
from contarm_sim.identify.search.shared import Shared, shared
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number, check_count

Criterion = Literal["D", "A"]
CRITERIA: tuple[Criterion, ...] = get_args(Criterion)

SAMPLES = 12
"""Of each random pattern."""
BETTER = 1e-9
"""Gain by which an exchange must be better."""


@dataclass(frozen=True, eq=False, repr=False)
class Excitation(Shown):
    """Which of Q candidate patterns to command next, and what that would tell of P parameters.

    Attributes:
        commands: of the chosen patterns, one after the other, SI units, shape (T, C).
        blocks: name of the pattern of each, shape (T,).
        names, units: of the parameters.
        values: where the information was taken, shape (P,).
        sd_before: expected standard deviation of each from what is known already, shape (P,); inf where that does not
            determine it. Of independent noise alone: what the model lacks comes on top.
        sd_after: with the chosen patterns measured besides.
        steps: expected standard deviations with none, one, two, ... of the chosen patterns, shape (count + 1, P).
        patterns: names of all candidates.
        chosen: numbers of the chosen ones, the most telling first.
        gain: of the choice: half the logarithm of the ratio of determinants (D), or by how much the sum of variances
            falls (A).
        gains: of each candidate alone, shape (Q,); NaN of refused ones.
        refused: names of candidates under which the arm has no pose, or whose commands are outside the limits.
    """

    commands: Array
    blocks: NDArray[np.str_]
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    sd_before: Array
    sd_after: Array
    steps: Array
    patterns: tuple[str, ...]
    chosen: tuple[int, ...]
    gain: float
    gains: Array
    refused: tuple[str, ...]


def excite(
    arm: Arm,
    rig: Rig,
    free: Sequence[Free | str],
    *,
    candidates: int | Array = 60,
    blocks: Sequence[str] | None = None,
    count: int = 4,
    criterion: Criterion = "D",
    recording: Recording | None = None,
    noise: float = 0.0005,
    bend: float = 1.0,
    limits: tuple[float, float] | None = None,
    predictor: Callable[[Recording], Predictor] | None = None,
    seed: int = 0,
) -> Excitation:
    """Return which commands to give next, so that a fit of the free parameters knows most.

    Args:
        arm, rig: as they are known: what a fit returned, or what it starts from.
        free: parameters, as of `fit`; their priors count.
        candidates: how many random patterns of windings to choose among, see `random_windings`; or a table of commands
            in SI units, shape (T, C), by the channels.
        blocks: of a table, what pattern each row belongs to, T names: patterns are taken whole; default: each row.
        count: patterns to choose, at most as many as there are.
        criterion: `D` or `A`, see the module.
        recording: that is there already, static.
        noise: standard deviation of a coordinate [m], such as a fit's.
        bend: of random patterns, largest bend of a section [rad].
        limits: lowest and highest command of any channel; a pattern that leaves them is refused.
        predictor: what predicts the markers, made of a recording; default that of `predictor_of`: where the arm rubs,
            each pattern then remembers those before it.
        seed: of random patterns.

    Raises:
        InputError: arguments that do not fit together, a motion, random patterns for channels that are not one winch
            each, or fewer candidates than are to be chosen, refused ones left out.
    """
    expect("arm", arm, Arm)
    arm.refuse_objects("commands are proposed")
    check_count("count", count, 1)
    if criterion not in CRITERIA:
        raise InputError("criterion", repr(criterion), ", ".join(CRITERIA))
    if not 0 < as_number(noise) < np.inf:
        raise InputError("noise", noise, "a length above 0 in metres")
    if recording is not None and recording.kind != "static":
        raise InputError("kind", "a motion", "a static recording: only static patterns are proposed", recording.name)
    commands, names = _candidates(arm, rig, candidates, blocks, bend, seed)
    patterns = tuple(dict.fromkeys(names.tolist()))
    bare = Recording(
        kind="static", time=np.arange(len(commands), dtype=float),
        positions=np.zeros((len(commands), len(rig.markers), 3)), commands=commands, rig=rig, blocks=names,
        name="candidates",
    )  # fmt: skip
    every = shared(arm, [bare], free)
    known = prior_precision(every.free, every.logarithmic, every.start)
    scales = plausible(every.free, every.units, every.logarithmic, every.start, (every.low, every.high), known)
    predictor = predictor or partial(predictor_of, arm=arm, names=every.names)
    slopes, lost = _slopes(every, bare, predictor)
    slopes = slopes.reshape(len(commands), -1, len(scales)) * scales / noise
    if limits is not None:
        lost = lost | ((commands < limits[0]) | (commands > limits[1])).any(axis=1)
    own = [names == pattern for pattern in patterns]
    fine = [place for place, rows in enumerate(own) if not lost[rows].any()]
    if len(fine) < count:
        said = f"{len(fine)} of {len(patterns)}: under the others the arm has no pose or they leave the limits"
        raise InputError("count", count, f"at most the candidates that can be commanded, {said}")
    told = np.array([np.einsum("tri,trj->ij", slopes[own[place]], slopes[own[place]]) for place in fine])
    known = np.diag(known * scales**2)
    if recording is not None:
        before = recording.in_rig(rig)
        found, missing = _slopes(shared(arm, [before], free), before, predictor)
        if missing.any():
            raise InputError(recording.name, f"{int(missing.sum())} samples", "commands under which the arm has a pose")
        found = found * scales / noise
        known = known + found.T @ found
    score = _score(known, criterion)
    picked = _exchanged(told, score, count)
    gained = [told[picked[:k]].sum(axis=0) for k in range(count + 1)]
    gains = np.full(len(patterns), np.nan)
    gains[fine] = score(told)
    values = every.of_vector(every.start)
    size = scales * np.where(every.logarithmic, values, 1.0)
    steps = np.array([size * expected_sd(known + each) for each in gained])
    chosen = tuple(fine[place] for place in picked)
    rows = np.concatenate([np.flatnonzero(own[place]) for place in chosen])
    return Excitation(
        commands[rows], names[rows], every.names, every.units, values, steps[0], steps[-1], steps, patterns, chosen,
        float(score(told[picked].sum(axis=0))), gains,
        tuple(pattern for place, pattern in enumerate(patterns) if place not in fine),
    )  # fmt: skip


def expected_sd(information: Array) -> Array:
    """Return standard deviations that an information matrix promises, both in steps of the scales, shape (P,).

    Infinite where it leaves a parameter to what is not determined.
    """
    values, along = np.linalg.eigh(information)
    nothing = values <= 1
    leak = np.sqrt((along[:, nothing] ** 2).sum(axis=1))
    inside = (along[:, ~nothing] ** 2 / values[~nothing]).sum(axis=1)
    return np.where(leak > LEAK, np.inf, np.sqrt(inside + leak**2))


def _candidates(
    arm: Arm, rig: Rig, candidates: int | Array, blocks: Sequence[str] | None, bend: float, seed: int
) -> tuple[Array, NDArray[np.str_]]:
    """Return commands, shape (T, C), and the pattern of each."""
    actuation = rig.actuation
    if not isinstance(candidates, int):
        table = np.array(candidates, dtype=float)
        if table.ndim != 2 or not np.isfinite(table).all() or table.shape[1] <= max(actuation.channels, default=-1):
            allowed = f"a table of finite numbers with {max(actuation.channels, default=-1) + 1} channels or more"
            raise InputError("candidates", f"of shape {table.shape}", allowed)
        names = np.array([f"row_{place + 1}" for place in range(len(table))] if blocks is None else list(blocks))
        if names.shape != (len(table),):
            raise InputError("blocks", f"{len(names)} names", f"{len(table)}, one for each row")
        return table, names
    check_count("candidates", candidates, 1)
    channels = actuation.channels
    if actuation.drive != "windings" or len(set(channels)) != len(channels) or not channels:
        raise InputError("candidates", candidates, "a table of commands, unless each channel winds one muscle in")
    windings, words = random_windings(arm, candidates * SAMPLES, seed, bend=bend, samples=SAMPLES)
    out = np.zeros((len(windings), len(actuation.gains)))
    worth = np.array(actuation.signs) * np.array(actuation.gains)[list(channels)]
    if not worth.all():
        raise InputError("actuation.gains", actuation.gains, "other than 0 for random patterns")
    out[:, list(channels)] = (windings + np.array(actuation.slack)) / worth
    return out, np.array(words)


def _slopes(
    every: Shared, recording: Recording, predictor: Callable[[Recording], Predictor]
) -> tuple[Array, NDArray[np.bool_]]:
    """Return derivatives of what was seen by the vector, shape (M, P), and which samples have no pose, shape (T,)."""
    nothing = np.zeros(len(recording), dtype=bool)
    problem = Problem(every, [recording], [nothing], [predictor(recording)], "linear")
    problem.base = every.start
    lost = ~np.isfinite(problem.predicted(every.start[None])[0][0]).all(axis=(1, 2))
    return problem.slopes(every.start, central=True), lost


def _score(known: Array, criterion: Criterion) -> Callable[[Array], Array]:
    """Return what information, shape (..., P, P), adds to what is known, shape (...)."""
    base = known + np.eye(len(known))

    def determinant(told: Array) -> Array:
        return 0.5 * np.asarray(np.linalg.slogdet(base + told)[1] - np.linalg.slogdet(base)[1])

    def variances(told: Array) -> Array:
        left = np.trace(np.linalg.inv(base + told), axis1=-2, axis2=-1)
        return np.asarray(np.trace(np.linalg.inv(base)) - left)

    return determinant if criterion == "D" else variances


def _exchanged(told: Array, score: Callable[[Array], Array], count: int) -> list[int]:
    """Return which to take, the most telling first: greedily, then exchanged one by one as long as that is better."""
    picked: list[int] = []
    for _ in range(count):
        picked.append(_best(told, score, picked)[0])
    best = float(score(told[picked].sum(axis=0)))
    while True:
        for place in range(count):
            others = [*picked[:place], *picked[place + 1 :]]
            found, gain = _best(told, score, others)
            if gain > best + BETTER * max(1.0, abs(best)):
                picked, best = [*others, found], gain
                break
        else:
            break
    ordered: list[int] = []
    while len(ordered) < count:
        rest = [place for place in picked if place not in ordered]
        values = score(told[ordered].sum(axis=0) + told[rest])
        ordered.append(rest[int(np.argmax(values))])
    return ordered


def _best(told: Array, score: Callable[[Array], Array], others: Sequence[int]) -> tuple[int, float]:
    values: Any = score(told[list(others)].sum(axis=0) + told)
    values[list(others)] = -np.inf
    place = int(np.argmax(values))
    return place, float(values[place])

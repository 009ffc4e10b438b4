"""What became of the parameters of a fit: intervals, correlations, what the data do not determine. Plain arrays in.

A fit calls it twice where something is not determined:

    judged = judge(...)                  # at the optimum of all parameters
    if judged.hold:                      # start again at judged.vector with these held there, the others free
        judged = judge(..., held=judged.hold)    # with all columns of the Jacobian, those of held ones too
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.identify.fitted import FOUND, Combination, Parameter, Status
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.judgement.bootstrap import one_step
from contarm_sim.identify.judgement.combinations import Direction, listed, with_interval
from contarm_sim.identify.judgement.identifiability import (
    LEAK,
    Seen,
    pivots,
    plausible,
    prior_in_vector,
    prior_precision,
    seen,
)
from contarm_sim.identify.judgement.intervals import Rows, Spread, noise_of, rows, spread
from contarm_sim.kinematics.arrays import Array

How = Literal["clustered", "plain"]

WEAK = float(np.log(3))
"""Half of an interval, in scales, from which on a parameter is weakly determined: a factor of 3 either way."""

APART = 3.0
"""Spreads of a prior from which on a value contradicts it."""


@dataclass(frozen=True, eq=False, repr=False)
class Judgement(Shown):
    """What became of P parameters.

    Attributes:
        parameters: values, intervals and statuses.
        undetermined: combinations that the data do not determine, the worst first; one for each number in `hold`.
        open: the directions of `undetermined`, in the vector, one plausible step long, shape (P, their number).
        hold: numbers of the parameters to hold at their start, so that the data determine the others.
        vector: the optimum, moved along what is not determined until those in `hold` are at their start, shape (P,).
        correlation: of errors, shape (P, P); NaN where one is not determined.
        covariance: of the vector's errors with `hold` held, shape (P, P); 0 in the rows of held ones.
        singular_values: of the Jacobian by scaled parameters, over the noise, shape (P,), the largest first.
        noise: of one coordinate, from the residuals [m].
        how: whether intervals count blocks as independent, or rows.
        degrees: of freedom of Student's t, shape (P,).
    """

    parameters: tuple[Parameter, ...]
    undetermined: tuple[Combination, ...]
    open: Array
    hold: tuple[int, ...]
    vector: Array
    correlation: Array
    covariance: Array
    singular_values: Array
    noise: float
    how: How
    degrees: Array


def judge(
    free: Sequence[Free],
    units: Sequence[str],
    logarithmic: Sequence[bool],
    start: Array,
    bounds: tuple[Array, Array],
    vector: Array,
    residual: Array,
    jacobian: Array,
    blocks: Any,
    *,
    noise: float,
    loss: str = "linear",
    loss_scale: float = 1.0,
    rounding: float = 1e-4,
    scales: Array | None = None,
    held: Sequence[int] = (),
    boot: int = 0,
    seed: int = 0,
) -> Judgement:
    """Return what became of P parameters of a fit to R measured coordinates.

    The fit minimised sum rho((residual / noise / loss_scale)^2) loss_scale^2 + sum ((vector - mean) / spread)^2, the
    second sum over the priors of `free` as `prior_in_vector` has them; the losses are those of SciPy's `least_squares`.

    Args:
        free: the parameters, with bounds and priors.
        units: of each.
        logarithmic: whether the vector has a parameter's logarithm.
        start: vector that the fit started from, shape (P,).
        bounds: lowest and highest vector, shape (P,) each, infinite where there is none.
        vector: optimum, shape (P,).
        residual: there, of all coordinates that were measured and kept for the fit [m], shape (R,): no NaN, no rows of
            priors, in the order of time within a block.
        jacobian: derivatives of `residual` by the vector, shape (R, P): of its sign, not weighted, not over the noise.
        blocks: label of each row's block, shape (R,): rows of one block are not independent.
        noise: of one coordinate that the fit weighted by [m].
        loss: `linear`, `soft_l1`, `huber` or `cauchy`, of one coordinate.
        loss_scale: beyond which residuals count as outliers, over the noise.
        rounding: relative error of the Jacobian's columns, from finite differences.
        scales: what each element of the vector may plausibly be wrong by, shape (P,); default
            `identifiability.plausible`.
        held: numbers of the parameters that the fit held.
        boot: resamples of a bootstrap over blocks; 0: none.
        seed: of the bootstrap.
    """
    prior = prior_precision(free, logarithmic, start)
    if scales is None:
        scales = plausible(free, units, logarithmic, vector, bounds, prior)
    told = rows(residual / noise, jacobian / noise, loss, loss_scale)
    labels = np.unique(np.asarray(blocks), return_inverse=True)[1]
    found, spreads = _seen_and_spread(told, labels, prior, scales, rounding, tuple(held))
    kept = [place for place in range(len(free)) if place not in found.hold]
    moved = vector + found.follows @ (start - vector)[list(found.hold)]
    moved[list(found.hold)] = start[list(found.hold)]
    moved = np.clip(moved, *bounds)
    booted = np.full((2, len(free)), np.nan)
    if boot and kept:
        steps = one_step(told.columns(kept), labels, prior[kept], boot, seed)
        booted[:, kept] = np.clip(moved[kept] + np.percentile(steps, (2.5, 97.5), axis=0), *(b[kept] for b in bounds))
        if spreads.clustered.any():  # what one block tells alone, no draw of blocks tells
            booted[:, [place for place, by_block in zip(kept, spreads.clustered, strict=True) if not by_block]] = np.nan
    directions = [
        Direction([one.name for one in free], units, logarithmic, scales, number, found.follows[:, place], sd)
        for place, (number, sd) in enumerate(zip(found.hold, found.sds.tolist(), strict=True))
    ]
    return _told(
        free, units, logarithmic, start, bounds, moved, found, spreads, booted, directions, scales, prior,
        noise * noise_of(residual / noise, len(kept), loss),
    )  # fmt: skip


def _seen_and_spread(
    told: Rows, labels: NDArray[np.intp], prior: Array, scales: Array, rounding: float, held: tuple[int, ...]
) -> tuple[Seen, Spread]:
    """Return what is seen, and the spread of what is not held: within its scale in every direction."""
    per_row = np.sqrt((told.psi**2).sum() / max(1, len(told.psi) - told.jacobian.shape[1])) / told.slope.mean()
    over = Rows(told.jacobian / max(float(per_row), 1e-12), told.psi, told.slope / told.slope.mean(), told.weight)
    while True:
        found = seen(over, prior, scales, rounding, held)
        kept = [place for place in range(len(scales)) if place not in found.hold]
        if not kept:
            return found, Spread(np.empty((0, 0)), np.empty(0), np.empty(0, dtype=bool))
        spreads = spread(told.columns(kept), labels, prior[kept])
        values, along = np.linalg.eigh(spreads.covariance / np.outer(scales[kept], scales[kept]))
        open_ones = along[:, values > 1]
        if not open_ones.size:
            return replace(found, sds=_along(told, labels, prior, scales, found, kept)), spreads
        held = (*found.hold, *(kept[place] for place in pivots(open_ones)))


def _along(
    told: Rows, labels: NDArray[np.intp], prior: Array, scales: Array, found: Seen, kept: list[int]
) -> Array:  # fmt: skip
    """Return the sds along directions, of both estimates the larger: were the held one free again."""
    out = found.sds.copy()
    for place, number in enumerate(found.hold):
        if out[place] <= 1:
            own = [*kept, number]
            alone = spread(told.columns(own), labels, prior[own]).sd[-1]
            out[place] = max(out[place], alone * np.linalg.norm(found.follows[:, place] / scales))
    return out


def _told(
    free: Sequence[Free], units: Sequence[str], logarithmic: Sequence[bool], start: Array, bounds: tuple[Array, Array],
    vector: Array, found: Seen, spreads: Spread, booted: Array, directions: list[Direction], scales: Array,
    prior: Array, noise: float,
) -> Judgement:  # fmt: skip
    count = len(free)
    kept = [place for place in range(count) if place not in found.hold]
    leak = found.leak(scales)
    sd, alone, degrees = np.full(count, np.nan), np.full(count, np.nan), np.full(count, np.nan)
    degrees[kept] = spreads.degrees
    alone[kept] = spreads.half_width()
    # what held ones may be off by, within their scales, is off here too
    sd[kept] = np.hypot(spreads.sd, leak[kept])
    half = np.hypot(alone, 1.96 * leak)
    out: list[Parameter] = []
    for place, one in enumerate(free):
        low, high = vector[place] - half[place], vector[place] + half[place]
        status, said = _status(place, vector, bounds, scales, found, leak, directions)
        if status == "only with others":
            said = _only(place, vector, alone[place], directions)
        elif status == "at bound":
            low, high = (low, vector[place]) if said == "upper" else (vector[place], high)
            said = f"at its {said} bound"
        elif status == "not seen":
            said = directions[found.hold.index(place)].said()
        elif prior[place]:
            said = _by_prior(one, logarithmic[place], start[place], vector[place], sd[place])
        elif status == "determined" and half[place] > WEAK * scales[place]:
            status, said = "weakly determined", "the recording hardly narrows it"
        values = np.array([vector[place], max(low, bounds[0][place]), min(high, bounds[1][place]), *booted[:, place]])
        values = np.exp(values) if logarithmic[place] else values
        if status in ("only with others", "not seen"):
            values[:] = np.nan
        began = float(np.exp(start[place]) if logarithmic[place] else start[place])
        own = sd[place] * (values[0] if logarithmic[place] else 1.0) + 0 * values[0]
        value, *ends = values.tolist()
        low, high, boot_low, boot_high = ends
        made = Parameter(one, units[place], began, value, float(own), low, high, boot_low, boot_high, status, said)
        out.append(made)
    known = np.array([one.status in FOUND for one in out])
    covariance = np.zeros((count, count))
    covariance[np.ix_(kept, kept)] = spreads.covariance
    correlation = np.full((count, count), np.nan)
    own = np.sqrt(np.diag(covariance))[known]
    correlation[np.ix_(known, known)] = covariance[np.ix_(known, known)] / np.outer(own, own)
    worst = sorted(directions, key=lambda one: -one.sd)
    steps = np.array([one.scaled * scales for one in worst]).reshape(-1, count).T
    return Judgement(
        tuple(out), tuple(one.combination() for one in worst), steps, found.hold, vector, correlation, covariance,
        found.singular_values, noise, "clustered" if spreads.clustered.any() else "plain", degrees,
    )  # fmt: skip


def _by_prior(one: Free, logarithmic: bool, start: float, found: float, sd: float) -> str:
    """Return how a prior and the recording agree, "" where nothing is to be said."""
    mean, spread = prior_in_vector(one, logarithmic, start)
    off = abs(found - mean) / spread
    if off > APART:
        return f"prior and recording contradict each other: it is {off:.2g} standard deviations off its prior"
    return "its prior alone: the recording adds nothing" if sd > 0.9 * spread else ""


def _status(
    place: int, vector: Array, bounds: tuple[Array, Array], scales: Array, found: Seen, leak: Array,
    directions: list[Direction]
) -> tuple[Status, str]:  # fmt: skip
    if place in found.hold and not directions[found.hold.index(place)].members:
        return "not seen", ""
    if place in found.hold or leak[place] > LEAK * scales[place]:
        return "only with others", ""
    near = 1e-4 * scales[place]
    if vector[place] >= bounds[1][place] - near:
        return "at bound", "upper"
    if vector[place] <= bounds[0][place] + near:
        return "at bound", "lower"
    return "determined", ""


def _only(place: int, vector: Array, half: float, directions: list[Direction]) -> str:
    """Return what is determined of a parameter with others, with its value and interval."""
    own = [one for one in directions if one.held == place]
    if own:
        follow = [own[0].determined(member) for member in own[0].members]
        return f"held at its start; see {listed(follow)}"
    others = [one for one in directions if place in one.members]
    if not others:  # a small part of several directions, which together are not small
        others = [max(directions, key=lambda one: abs(float(one.scaled[place])))]
    first = others[0]
    name, unit, logarithmic = first.names[place], first.units[place], bool(first.logarithmic[place])
    factors = logarithmic and all(one.logarithmic[one.held] for one in others)
    text, value = f"ln({name})" if logarithmic and not factors else name, vector[place]
    for one in others:
        text += one.term(place, factors)
        value -= one.power(place) * vector[one.held]
    alike = not logarithmic and all(one.units[one.held] == unit for one in others)
    return f"{text} = {with_interval(value, half, unit if alike else '', factors)}"

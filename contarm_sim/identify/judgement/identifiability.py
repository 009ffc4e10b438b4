"""Which directions of the parameters the data determine, and which parameters to hold so that the others can be found.

Singular values say nothing until the columns have a scale. Here an element of the vector is scaled by what it may
plausibly be wrong by before anything is measured (`plausible`). A direction whose standard deviation is larger than
that has not been measured: the data leave as much as was known without them. One whose singular value is within the
rounding of the finite differences has not been seen at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.judgement.intervals import Rows
from contarm_sim.kinematics.arrays import Array

USUAL = {"m": 0.01, "rad": 0.5, "N": 1.0, "Pa": 1e4}
"""What a parameter that has no logarithm in the vector may be wrong by, by its unit: 10 mm, 29 degrees, ...

10 mm is what a marker is glued and a base is placed to by hand, 0.5 rad what a frame is turned to by eye.
"""
LEAK = 0.1
"""A parameter hangs on held ones if it moves by more than this part of its scale where they move by theirs."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What the data see of P parameters.

    Attributes:
        singular_values: of the Jacobian, scaled and over the noise, with the rows of priors, shape (P,).
        hold: parameters to hold, so that the others are determined: those without effect first.
        unseen: those of `hold` that have no effect of their own, whatever the others do.
        follows: how the optimum of all elements moves with each held one, shape (P, len(hold)); 1 at itself.
        sds: along each such direction, in steps of the scales; inf where nothing is seen.
    """

    singular_values: Array
    hold: tuple[int, ...]
    unseen: tuple[int, ...]
    follows: Array
    sds: Array

    def leak(self, scales: Array) -> Array:
        """Return how far elements move if the held ones are off by their scales, shape (P,); 0 without any."""
        moved = self.follows * scales[list(self.hold)]
        moved[list(self.hold)] = 0.0
        return np.sqrt((moved**2).sum(axis=1))


def plausible(
    free: Sequence[Free],
    units: Sequence[str],
    logarithmic: Sequence[bool],
    vector: Array,
    bounds: tuple[Array, Array],
    known: Array,
) -> Array:
    """Return what each element of the vector may plausibly be wrong by, shape (P,).

    A positive parameter, in the vector by its logarithm: a factor e. Others by their unit (`USUAL`), or by themselves
    where it says nothing. Not more than half of what bounds leave: data that do not narrow them tell nothing. Not less
    than a prior's spread (`known` is 1 / variance): a parameter with a prior is known from it.
    """
    out = np.ones(len(free))
    for place, (unit, positive) in enumerate(zip(units, logarithmic, strict=True)):
        if not positive:
            out[place] = USUAL.get(unit, abs(vector[place]) or 1.0)
    with np.errstate(invalid="ignore"):
        width = 0.5 * (bounds[1] - bounds[0])
    out = np.where(np.isfinite(width) & (width > 0), np.minimum(out, width), out)
    return np.where(known > 0, np.maximum(out, 1.001 / np.sqrt(np.maximum(known, 1e-300))), out)


def prior_precision(free: Sequence[Free], logarithmic: Sequence[bool], start: Array) -> Array:
    """Return 1 / variance of the priors in the vector, 0 where there is none, shape (P,)."""
    out = np.zeros(len(free))
    for place, one in enumerate(free):
        if one.sd is not None:
            out[place] = prior_in_vector(one, logarithmic[place], float(start[place]))[1] ** -2
    return out


def prior_in_vector(one: Free, logarithmic: bool, start: float) -> tuple[float, float]:
    """Return the mean and the spread of a parameter's prior in the vector: of a logarithm, ln(mean) and sd / mean.

    Args:
        one: the parameter, which has a prior.
        logarithmic: whether the vector has its logarithm.
        start: its element of the vector at the start, the mean where none is given.

    Raises:
        InputError: a mean that the parameter cannot have.
    """
    assert one.sd is not None
    if not logarithmic:
        return start if one.mean is None else one.mean, one.sd
    mean = float(np.exp(start)) if one.mean is None else one.mean
    if not mean > 0:
        raise InputError(f"prior of {one.name}", mean, "a mean above 0, as the parameter is")
    return float(np.log(mean)), one.sd / mean


def seen(told: Rows, prior: Array, scales: Array, rounding: float, held: Sequence[int] = ()) -> Seen:
    """Return what rows of data, with priors, see of the parameters.

    Args:
        told: rows over the noise.
        prior: 1 / variance of each element from elsewhere, shape (P,).
        scales: of the elements, shape (P,).
        rounding: relative error of the Jacobian's columns.
        held: parameters that are held already.
    """
    data = np.sqrt(told.slope)[:, None] * told.jacobian * scales
    every = np.vstack([data, np.diag(np.sqrt(prior) * scales)])
    sizes, alone = np.linalg.norm(data, axis=0), np.linalg.norm(every, axis=0)
    nothing = alone <= np.maximum(1.0, rounding * sizes.max(initial=0.0))
    unseen = [int(place) for place in np.flatnonzero(nothing)]
    hold = [*held, *(place for place in unseen if place not in held)]
    free = [place for place in range(len(scales)) if place not in hold]
    if free:
        _, values, right = np.linalg.svd(every[:, free], full_matrices=False)
        floor = np.maximum(1.0, rounding * np.sqrt((right**2 * sizes[free] ** 2).sum(axis=1)))
        hold += [free[place] for place in pivots(right[values <= floor].T)]
        free = [place for place in free if place not in hold]
    follows, sds = np.zeros((len(scales), len(hold))), np.zeros(len(hold))
    follows[hold, range(len(hold))] = 1.0
    if free and hold:
        follows[free] = -np.linalg.lstsq(every[:, free], every[:, hold], rcond=None)[0]
    for place in range(len(hold)):
        along = follows[:, place] / np.linalg.norm(follows[:, place])
        size = float(np.linalg.norm(every @ along))
        sds[place] = 1 / size if size > rounding * np.linalg.norm(sizes * along) else np.inf
    follows = follows * scales[:, None] / scales[hold]
    return Seen(np.asarray(np.linalg.svd(every, compute_uv=False)), tuple(hold), tuple(unseen), follows, sds)


def pivots(null: Array) -> list[int]:
    """Return rows of independent directions, shape (P, n), that say how far each goes: the largest parts first.

    Of two alike it is the later one.
    """
    from scipy.linalg import qr

    if not null.size:
        return []
    biased = null * (1 + 1e-3 * np.arange(len(null)))[:, None]
    _, _, order = qr(biased.T, mode="economic", pivoting=True)
    return [int(place) for place in order[: null.shape[1]]]

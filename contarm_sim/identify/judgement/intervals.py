"""How far the parameters of a fit may be off: covariances from the Jacobian, and the quantiles that belong to them.

Residuals of one block are not independent: what the model lacks, or what the arm remembers, moves them together. So
there are two estimates.

clustered   Of `ENOUGH` blocks or more. Bread times meat times bread, the meat from the scores of whole blocks,
            residuals corrected for leverage as the jackknife does (CR3: each block left out once), and Student's t
            with as many degrees of freedom as each parameter's own estimate has (Bell and McCaffrey 2002; MacKinnon,
            Nielsen and Webb 2023, doi 10.1016/j.jeconom.2022.04.001). It holds whatever the residuals of one block
            have in common. In simulations of linear fits of 2 to 20 parameters to 6 to 40 blocks it covers 95.5 to
            98.7 %, of independent residuals and of an offset for each block; the milder correction, CR2, covers 78 to
            94 % of the latter. The price: of independent residuals it is 1.1 (40 blocks) to 1.9 times (6) as wide.
plain       Of fewer blocks: residuals count as independent, of one spread, sigma^2 (J^T J)^-1 with Huber's correction
            for robust losses (Huber and Ronchetti 2009, eq. 7.81), n - p degrees of freedom. Successive pieces of
            blocks, of `PIECE` rows or more, are clusters too, if there are enough, and the larger of the two
            variances is taken: it holds for what residuals have in common for a short time, not for a whole block.

The clustered estimate is taken for each parameter only if it rests on more than `LEAST` degrees of freedom. One that
a single block tells keeps the plain one, widened as those of the others are in the middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.identify.search.losses import LOSSES, rho
from contarm_sim.kinematics.arrays import Array

ENOUGH = 6
"""Blocks that the clustered estimate needs."""
PIECES = 20
"""Pieces that fewer blocks are cut into."""
PIECE = 12
"""Rows that a piece has at least."""
LEAST = 2.0
"""Degrees of freedom that a clustered estimate needs."""
ALONE = 1e-6
"""What a block leaves of a direction at most that it alone tells."""
LEAST_VARIANCE = 1e-12
"""Of residuals over the noise: a perfect fit has none."""
CORE = 3.0
"""Of a first estimate of the noise, what is counted in the second."""
CUT = 0.9733
"""Variance of a standard normal distribution that is cut at `CORE`."""
LEVEL = 0.95
"""Of intervals."""


@dataclass(frozen=True, eq=False)
class Rows:
    """R measured coordinates over the noise, weighed by a robust loss.

    Attributes:
        jacobian: derivatives of the residuals by P elements of the vector, shape (R, P).
        psi: half the loss's derivative by the residual, shape (R,): the residual itself where the loss is linear.
        slope: its derivative, 0 or more, shape (R,).
        weight: psi over the residual, shape (R,).
    """

    jacobian: Array
    psi: Array
    slope: Array
    weight: Array

    def columns(self, own: list[int]) -> Rows:
        """Return the same rows with some columns alone."""
        return Rows(self.jacobian[:, own], self.psi, self.slope, self.weight)

    @property
    def hessian(self) -> Array:
        """J^T diag(slope) J, shape (P, P)."""
        return np.asarray(self.jacobian.T @ (self.slope[:, None] * self.jacobian))


@dataclass(frozen=True, eq=False)
class Spread:
    """How far the vector may be off.

    Attributes:
        covariance: shape (P, P).
        degrees: of freedom of Student's t, shape (P,).
        clustered: whether the variance of an element counts blocks as independent, shape (P,).
    """

    covariance: Array
    degrees: Array
    clustered: NDArray[np.bool_]

    @property
    def sd(self) -> Array:
        """Standard deviations, shape (P,)."""
        return np.sqrt(np.diag(self.covariance))

    def half_width(self, level: float = LEVEL) -> Array:
        """Return half the width of the intervals, shape (P,)."""
        from scipy.stats import t

        return np.asarray(self.sd * t.ppf(0.5 + 0.5 * level, self.degrees))


def rows(residual: Array, jacobian: Array, loss: str = "linear", scale: float = 1.0) -> Rows:
    """Return what intervals need of R residuals over the noise.

    Args:
        residual: over the noise, shape (R,).
        jacobian: derivatives over the noise, shape (R, P).
        loss: as SciPy's `least_squares` names it.
        scale: beyond which residuals count as outliers.

    Raises:
        InputError: an unknown loss.
    """
    if loss not in LOSSES:
        raise InputError("loss", repr(loss), ", ".join(LOSSES))
    z = (residual / scale) ** 2
    _, weight, bend = rho(z, loss)
    return Rows(jacobian, weight * residual, np.maximum(weight + 2 * z * bend, 0.0), weight)


def noise_of(residual: Array, parameters: int, loss: str) -> float:
    """Return the spread of residuals, shape (R,), of a fit of some parameters, in their unit.

    Of a robust loss by their median, then by the squares of what is within `CORE` times that: with one in ten that are
    outliers the first is 13 % too large, the second is not, and it scatters half as much.
    """
    left = max(1.0, len(residual) - parameters)
    if loss == "linear":
        return float(np.sqrt((residual**2).sum() / left))
    sizes = np.abs(residual)
    core = sizes[sizes <= CORE * 1.4826 * np.median(sizes)]
    return float(np.sqrt((core**2).mean() / CUT * len(residual) / left))


def spread(told: Rows, blocks: NDArray[np.intp], prior: Array) -> Spread:
    """Return how far the vector may be off; see the module.

    Args:
        told: the rows.
        blocks: number of each row's block, shape (R,).
        prior: what is known from elsewhere, 1 / variance of each element, 0 where nothing is, shape (P,).
    """
    plain = _plain(told, prior)
    enough = len(np.unique(blocks)) >= ENOUGH
    groups = blocks if enough else pieces(blocks)
    if len(np.unique(groups)) < ENOUGH:
        return plain
    by_group = _clustered(told, groups, prior)
    taken = (by_group.degrees > LEAST) & (by_group.sd > 1e-3 * plain.sd)  # not where the fit is perfect
    if not enough:
        taken &= by_group.sd > plain.sd
    if not taken.any():
        return plain
    wider = max(1.0, float(np.median((by_group.sd / plain.sd)[taken]))) if enough else 1.0
    sd = np.where(taken, by_group.sd, wider * plain.sd)
    source = by_group.covariance if taken.all() else plain.covariance
    own = np.sqrt(np.diag(source))
    scaled = source * np.outer(sd / own, sd / own)
    return Spread(scaled, np.where(taken, by_group.degrees, plain.degrees), taken & enough)


def pieces(blocks: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return blocks cut into about `PIECES` successive pieces of `PIECE` rows or more, shape (R,)."""
    length = max(PIECE, -(-len(blocks) // PIECES))
    out, first = np.empty(len(blocks), dtype=np.intp), 0
    for block in np.unique(blocks):
        own = np.flatnonzero(blocks == block)
        count = max(1, len(own) // length)
        out[own] = first + np.arange(len(own)) * count // len(own)
        first += count
    return out


def _plain(told: Rows, prior: Array) -> Spread:
    bread = np.asarray(np.linalg.inv(told.hessian + np.diag(prior)))
    count = len(told.psi)
    used = float(np.trace(bread @ told.hessian))
    left = max(1.0, count - used)
    mean = float(told.slope.mean())
    correction = 1 + used / count * float(told.slope.var()) / mean**2
    least = LEAST_VARIANCE if count - used > 1 else 1.0  # nothing is left to tell the noise from: it is as was given
    variance = max(correction**2 * float((told.psi**2).sum()) / left, least)
    meat = variance * told.jacobian.T @ told.jacobian + np.diag(prior)
    size = len(prior)
    return Spread(bread @ meat @ bread, np.full(size, left), np.zeros(size, dtype=bool))


def _clustered(told: Rows, groups: NDArray[np.intp], prior: Array) -> Spread:
    """CR3 and Bell-McCaffrey degrees of freedom, all by the P columns of each group's factor: groups may be long."""
    bread = np.asarray(np.linalg.inv(told.hessian + np.diag(prior)))
    root = np.sqrt(told.weight)
    design, residual = root[:, None] * told.jacobian, told.psi / root
    inverse = np.asarray(np.linalg.inv(design.T @ design + np.diag(prior)))
    half = np.linalg.cholesky(inverse)
    scores, adjusted, squares, lost, every = [], [], [], np.zeros_like(half), np.unique(groups)
    pulled = told.jacobian.T @ told.psi / len(every)  # by bounds and priors at the optimum: no part of the spread
    for group in every:
        own = groups == group
        left, values, right = np.linalg.svd(design[own] @ half, full_matrices=False)
        # (1 - H)^-1 of the group differs from 1 only along `left`; of what it alone tells it leaves no residual
        rest = 1 - values**2
        stretch = np.where(rest > ALONE, 1 / np.maximum(rest, ALONE), 0.0)
        lost += right[rest <= ALONE].T @ right[rest <= ALONE]
        design_adjusted = (left * (stretch * values)) @ right @ np.linalg.inv(half)
        pull = pulled + np.linalg.solve(half.T, right.T @ ((stretch - 1) * (right @ (half.T @ pulled))))
        scores.append(design_adjusted.T @ residual[own] - pull)
        adjusted.append(design[own].T @ design_adjusted)
        squares.append(design_adjusted.T @ design_adjusted)
    meat = np.array(scores).T @ np.array(scores) + np.diag(prior)
    degrees = _degrees(bread, inverse, np.array(adjusted), np.array(squares), prior)
    told_by_one = np.diag(half @ lost @ half.T) > 0.1 * np.diag(inverse)
    return Spread(bread @ meat @ bread, np.where(told_by_one, 0.0, degrees), ~told_by_one)


def _degrees(bread: Array, inverse: Array, adjusted: Array, squares: Array, prior: Array) -> Array:
    """Return (sum of eigenvalues)^2 / sum of their squares of each element's variance, were all rows independent."""
    out = np.empty(len(bread))
    for place, along in enumerate(bread):
        between = np.einsum("gij,j->gi", adjusted, along)
        gram = -between @ inverse @ between.T
        gram[np.diag_indices(len(gram))] += np.einsum("i,gij,j->g", along, squares, along)
        known = float((along**2 * prior).sum())  # the part of priors has no estimate in it
        out[place] = (np.trace(gram) + known) ** 2 / max(float((gram**2).sum()), 1e-300)
    return out

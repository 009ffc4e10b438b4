"""What became of the parameters of a fit: intervals, correlations, what the data do not determine. Plain arrays in.

A fit calls it twice where something is not determined:

    judged = judge(...)                  # at the optimum of all parameters
    if judged.hold:                      # start again at judged.vector with these held there, the others free
        judged = judge(..., held=judged.hold)    # with all columns of the Jacobian, those of held ones too
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from contarm_sim.display import Shown
from contarm_sim.identify.fitted import Combination, Parameter
from contarm_sim.identify.freedom import Free
from contarm_sim.kinematics.arrays import Array

How = Literal["clustered", "plain"]


@dataclass(frozen=True, eq=False, repr=False)
class Judgement(Shown):
    """What became of P parameters.

    Attributes:
        parameters: values, intervals and statuses.
        undetermined: combinations that the data do not determine, the worst first; one for each number in `hold`.
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

    The fit minimised sum rho((residual / noise / loss_scale)^2) loss_scale^2 + sum ((value - mean) / sd)^2, the second
    sum over the priors of `free` (in the vector: of a logarithm, sd / mean), as SciPy's `least_squares` does.

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
    raise NotImplementedError

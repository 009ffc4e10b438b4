"""Intervals by drawing whole blocks again: what parameters had come out, had other blocks been recorded.

`one_step` takes a Newton step from the optimum with the blocks drawn, which costs no prediction.
Blocks of one pattern or trial are drawn whole, since their residuals are not independent. Of few blocks, successive
pieces are drawn in their place (`intervals.pieces`): what residuals have in common is then taken to be short.
Percentiles are of steps that are widened for few blocks, by sqrt(G / (G - 1)) and by Student's t over the normal
quantile: G blocks drawn from G vary too little.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contarm_sim.identify.judgement.intervals import ENOUGH, Rows, pieces
from contarm_sim.kinematics.arrays import Array


def groups(blocks: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return what is drawn whole: the blocks, or pieces of them where they are few, numbers from 0, shape (R,)."""
    return np.unique(blocks if len(np.unique(blocks)) >= ENOUGH else pieces(blocks), return_inverse=True)[1]


def one_step(told: Rows, blocks: NDArray[np.intp], prior: Array, count: int, seed: int = 0) -> Array:
    """Return steps of the vector from the optimum, shape (count, P), each of blocks drawn anew.

    Args:
        told: rows over the noise, at the optimum.
        blocks: number of each row's block, shape (R,).
        prior: 1 / variance of each element from elsewhere, shape (P,); its mean is drawn too.
        count: resamples.
        seed: of the draws.
    """
    rng, own = np.random.default_rng(seed), groups(blocks)
    size, places = int(own.max()) + 1, told.jacobian.shape[1]
    scores, squares = np.zeros((size, places)), np.zeros((size, places, places))
    for group in range(size):
        rows = own == group
        jacobian = told.jacobian[rows]
        scores[group] = jacobian.T @ told.psi[rows]
        squares[group] = jacobian.T @ (told.slope[rows, None] * jacobian)
    # what bounds or priors pull at the optimum is no part of the blocks' spread
    scores -= scores.mean(axis=0)
    drawn = rng.multinomial(size, np.full(size, 1 / size), size=count)
    hessian = np.einsum("bg,gij->bij", drawn, squares) + np.diag(prior)
    gradient = drawn @ scores + rng.standard_normal((count, places)) * np.sqrt(prior)
    # a draw without any block that tells some parameter has no answer: the smallest step is taken
    steps = -np.linalg.pinv(hessian, rcond=1e-10, hermitian=True) @ gradient[..., None]
    return np.asarray(steps[..., 0] * widening(size))


def widening(size: int) -> float:
    """Return how much wider steps of a number of blocks are made."""
    from scipy.stats import norm, t

    return float(np.sqrt(size / (size - 1)) * t.ppf(0.975, size - 1) / norm.ppf(0.975)) if size > 1 else 1.0

"""The residuals of a fit: what every marker's coordinate is off by, priors behind them, and their Jacobian."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.identify.prediction.base import Predictor
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.search.losses import THRESHOLD, Loss, rho
from contarm_sim.identify.search.shared import Shared, prior_of
from contarm_sim.kinematics.arrays import Array

STEP, WIDE_STEP = 2e-4, 2e-3
"""Steps of finite differences from one side and from both, over a parameter's typical change."""

TETHER = 20.0
"""Spread of a prior that every parameter has about its start, over its typical change.

So weak that it moves nothing that data determine; it keeps what they do not from running off.
"""

LOST = 1.0
"""Residual of a coordinate that has no prediction, over the length of the arm."""

LEAST_NOISE = 1e-7
"""Least noise of a coordinate, over the length of the arm: what poses at rest are found to."""


@dataclass(frozen=True)
class Progress:
    """How far a fit is.

    Attributes:
        phase: what it does, such as `start 2 of 8`, `search`, `intervals`.
        evaluation: predictions of all recordings until now.
        rms: distance, at the best until now, of what is fitted from what is predicted [m], root mean square.
        of: predictions at which the phase ends, or None where nobody knows.
    """

    phase: str
    evaluation: int
    rms: float
    of: int | None = None


class Problem:
    """Residuals of P free parameters, M coordinates of markers that were seen and are not held out.

    Args:
        every: the parameters.
        recordings: that they are fitted to.
        held: which samples of each are kept from the fit, shape (T,).
        predictors: one for each recording.
        loss: see `losses`.
        on_progress: told how far it is, after each prediction.

    Attributes:
        active: which parameters move, shape (P,); the others stay at `base`.
        base: the vector that the others have, shape (P,).
        evaluations: predictions of all recordings until now.
        lost: coordinates of the last vector that have no prediction.
        of: evaluations at which the present phase ends, where that is known.
        best: the best vector of the present search, shape (P,), and its cost; None before the first.
    """

    def __init__(
        self,
        every: Shared,
        recordings: Sequence[Recording],
        held: Sequence[NDArray[np.bool_]],
        predictors: Sequence[Predictor],
        loss: Loss,
        on_progress: Callable[[Progress], None] | None = None,
    ) -> None:
        self.every, self.recordings, self.predictors, self.loss = every, tuple(recordings), tuple(predictors), loss
        self._rows = [
            np.isfinite(one.positions) & ~out[:, None, None] for one, out in zip(recordings, held, strict=True)
        ]
        self._measured = np.concatenate([one.positions[own] for one, own in zip(recordings, self._rows, strict=True)])
        self.size, self.length = len(self._measured), every.arm.length
        self._markers = sum(int(own.any(axis=-1).sum()) for own in self._rows)
        self.active = np.ones(len(every.free), dtype=bool)
        self.base = every.start.copy()
        self.evaluations, self.lost, self.noise = 0, 0, 1.0
        self.phase, self._said, self._rms = "search", on_progress, np.inf
        self.best: tuple[Array, float] | None = None
        self.of: int | None = None
        known = [place for place, one in enumerate(every.free) if one.sd is not None]
        priors = np.array([prior_of(every, place) for place in known]).reshape(-1, 2)
        self._known = np.array([*range(len(every.free)), *known])
        self._means = np.concatenate([every.start, priors[:, 0]])
        self._spreads = np.concatenate([TETHER * every.typical, priors[:, 1]])

    @property
    def blocks(self) -> NDArray[np.str_]:
        """The block of each residual, shape (M,)."""
        several = len(self.recordings) > 1
        found = []
        for place, (one, own) in enumerate(zip(self.recordings, self._rows, strict=True)):
            names = np.char.add(f"{place + 1}: ", one.blocks) if several else one.blocks
            found.append(np.broadcast_to(names[:, None, None], own.shape)[own])
        return np.concatenate(found)

    def full(self, moved: Array) -> Array:
        """Return whole vectors, shape (..., P), of what moves."""
        out = np.broadcast_to(self.base, (*moved.shape[:-1], len(self.base))).copy()
        out[..., self.active] = moved
        return out

    def predicted(self, vectors: Array) -> list[Array]:
        """Return where the markers of each recording are predicted [m], shape (B, T, K, 3) each, of vectors (B, P).

        NaN where there is no pose; so too of vectors that no arm can have.
        """
        made, kept = [], []
        for place, vector in enumerate(vectors):
            try:
                made.append(self.every.applied(vector))
            except InputError:
                continue
            kept.append(place)
        out = [np.full((len(vectors), *one.positions.shape), np.nan) for one in self.recordings]
        if made:
            arms = [arm for arm, _ in made]
            for place, (predictor, found) in enumerate(zip(self.predictors, out, strict=True)):
                found[kept] = predictor(arms, [rigs[place] for _, rigs in made])
        self.evaluations += len(vectors)
        return out

    def errors(self, vectors: Array) -> Array:
        """Return measured less predicted [m], shape (B, M), of vectors (B, P); NaN where nothing is predicted."""
        every = zip(self.predicted(vectors), self._rows, strict=True)
        found = self._measured - np.concatenate([found[:, own] for found, own in every], axis=1)
        return np.where(np.isfinite(found), found, np.nan)

    def filled(self, errors: Array) -> Array:
        """Return errors [m], shape (..., M), with a large number in place of those that have no prediction."""
        return np.where(np.isfinite(errors), errors, LOST * self.length)

    def priors(self, vector: Array) -> Array:
        """Return how far a vector is off what is known beforehand, over the spreads, shape (Q,)."""
        return (vector[self._known] - self._means) / self._spreads

    def cost(self, errors: Array, vector: Array, noise: float | None = None) -> float:
        """Return half the weighted sum of losses of errors [m], shape (M,), and of priors."""
        noise = self.noise if noise is None else noise
        losses = THRESHOLD**2 * rho((self.filled(errors) / (THRESHOLD * noise)) ** 2, self.loss)[0]
        return 0.5 * float(losses.sum() + (self.priors(vector) ** 2).sum())

    def residuals(self, moved: Array) -> Array:
        """Return errors over the noise, and `priors`, shape (M + Q,), of what moves; remembers the best."""
        vector = self.full(moved)
        errors = self.errors(vector[None])[0]
        self.lost = int(np.isnan(errors).sum())
        self.note(vector, errors)
        return np.concatenate([self.filled(errors) / self.noise, self.priors(vector)])

    def note(self, vector: Array, errors: Array) -> None:
        """Remember a vector, shape (P,), if it is the best with its errors [m], (M,); tell how far the fit is."""
        cost = self.cost(errors, vector)
        if self.best is None or cost < self.best[1]:
            self.best = (vector.copy(), cost)
            self._rms = float(np.sqrt((self.filled(errors) ** 2).sum() / self._markers))
        self.tell()

    def tell(self) -> None:
        """Tell how far the fit is."""
        if self._said is not None:
            self._said(Progress(self.phase, self.evaluations, self._rms, self.of))

    def slopes(self, moved: Array, central: bool = False) -> Array:
        """Return the derivatives of errors by what moves [m], shape (M, active), all in one population.

        Where no step leads to a pose, or from none, they are 0.

        Args:
            moved: where they are taken, shape (active,).
            central: from both sides, except at a bound.
        """
        steps, vector = (WIDE_STEP if central else STEP) * self.every.typical, self.full(moved)
        places = np.flatnonzero(self.active)
        up = np.where(vector + steps <= self.every.high, steps, 0.0)
        down = np.where(vector - steps >= self.every.low, -steps, 0.0) if central else np.where(up > 0, 0.0, -steps)
        sides = [(k, place, side[place]) for side in (up, down) for k, place in enumerate(places) if side[place]]
        population = np.tile(vector, (1 + len(sides), 1))
        for row, (_, place, step) in enumerate(sides):
            population[1 + row, place] += step
        errors = self.errors(population)
        total = np.zeros((len(places), self.size))
        width = np.zeros((len(places), self.size))
        for row, (k, _, step) in enumerate(sides):
            change = errors[1 + row] - errors[0]
            total[k] += np.sign(step) * np.nan_to_num(change)
            width[k] += abs(step) * np.isfinite(change)  # a side without a pose is no part of the step
        self.tell()
        return np.asarray((total / np.maximum(width, 1e-300)).T)

    def jacobian(self, moved: Array) -> Array:
        """Return the derivatives of `residuals`, shape (M + Q, active)."""
        priors = np.zeros((len(self._known), len(self.base)))
        priors[range(len(priors)), self._known] = 1 / self._spreads
        return np.concatenate([self.slopes(moved) / self.noise, priors[:, self.active]])

    def scipy_loss(self, squares: Array) -> Array:
        """Return losses and derivatives, shape (3, M + Q), of squares over the threshold, (M + Q,); not of priors."""
        found = rho(squares, self.loss)
        found[:, self.size :] = rho(squares[self.size :], "linear")
        return found

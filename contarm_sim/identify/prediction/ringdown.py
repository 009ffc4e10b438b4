"""Frequency and damping of a free swing, by one measure for what is measured and for what is predicted.

The swing is seen along the line that most of it lies on, from the start that is given, and fitted by

    s(t) = A exp(-d t) cos(2 pi f t + phase) + c

with a loss that grows linearly beyond a twentieth of the swing, so that a few bad samples count little. Where friction
makes a swing faster and more damped as it fades, f and d are those of all of it, large amplitudes first: they depend on
the start and on how long it is looked at, so compare swings from the same start over the same time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array

FEWEST = 8
"""Fewest samples that five numbers are fitted to."""

_RATIOS = (0.0, 0.01, 0.05, 0.1, 0.2, 0.4, 0.7)  # damping ratios tried
_FREQUENCIES = 80  # and frequencies


@dataclass(frozen=True, repr=False)
class Ringdown(Shown):
    """A damped cosine fitted to a swing.

    Attributes:
        frequency: of the damped swing [Hz].
        damping: d, how fast it fades [1/s].
        amplitude: A, at the start [m].
        direction: that it swings in, a unit vector, shape (3,).
        left: rms of what the fit leaves [m].
    """

    frequency: float
    damping: float
    amplitude: float
    direction: Array
    left: float


def ringdown(time: Array, positions: Array, direction: Array | None = None) -> Ringdown:
    """Return the damped cosine that fits a swing best.

    Args:
        time: [s], shape (T,), from the start of the swing.
        positions: of a marker [m], shape (T, 3); NaN where it was not seen.
        direction: to see it along; default that of its largest spread.

    Raises:
        InputError: fewer than eight samples, or a marker that does not move.
    """
    from scipy.optimize import least_squares

    time, positions = np.asarray(time, dtype=float), np.asarray(positions, dtype=float)
    seen = np.isfinite(positions).all(axis=-1)
    if np.count_nonzero(seen) < FEWEST:
        raise InputError("swing", f"{np.count_nonzero(seen)} samples", f"{FEWEST} or more at which the marker is seen")
    t, own = time[seen] - time[0], positions[seen]
    middle = np.median(own, axis=0)
    if direction is None:
        direction = _line(own - middle)
    s = (own - middle) @ direction
    spread = float(np.abs(s).max())
    if not spread > 0:
        raise InputError("swing", "a marker that does not move", "one that swings")
    start = _grid(t, s / spread)
    found = least_squares(
        lambda x: _cosine(x, t) - s / spread, start, loss="soft_l1", f_scale=0.05, x_scale=[1, 1, 1, start[3], 1]
    )
    x = found.x
    left = spread * float(np.sqrt(np.mean((_cosine(x, t) - s / spread) ** 2)))
    return Ringdown(abs(float(x[3])), float(x[2]), spread * float(np.hypot(x[0], x[1])), direction, left)


def _line(away: Array) -> Array:
    """Return the direction of the line through the origin that points are near to, shape (3,); outliers count less."""
    weights, direction = np.ones(len(away)), np.zeros(3)
    for _ in range(10):
        direction = np.linalg.eigh((away.T * weights) @ away)[1][:, -1]
        beside = np.linalg.norm(away - np.outer(away @ direction, direction), axis=1)
        weights = 1 / (beside**2 + (0.05 * np.abs(away).max()) ** 2 + 1e-300)
    return direction


def _cosine(x: Array, t: Array) -> Array:
    a, b, d, f, c = x
    return np.asarray(np.exp(-d * t) * (a * np.cos(2 * np.pi * f * t) + b * np.sin(2 * np.pi * f * t)) + c)


def _grid(t: Array, s: Array) -> Array:
    """Return the best of many frequencies and damping ratios, the rest of the numbers by linear least squares.

    Frequencies go up to half the sampling rate. The strongest of the spectrum is among them: between the others a swing
    of many periods is missed.
    """
    from scipy.signal import lombscargle

    highest = 0.5 / float(np.median(np.diff(t)))
    fine = np.arange(0.5 / t[-1], highest, 0.2 / t[-1])
    strongest = fine[np.argmax(lombscargle(t, s - s.mean(), 2 * np.pi * fine))]
    best, cost = np.zeros(5), np.inf
    for f in [*np.geomspace(0.5 / t[-1], highest, _FREQUENCIES), strongest]:
        for ratio in _RATIOS:
            d = 2 * np.pi * f * ratio
            A = np.exp(-d * t)[:, None] * np.stack([np.cos(2 * np.pi * f * t), np.sin(2 * np.pi * f * t)], axis=-1)
            A = np.column_stack([A, np.ones(len(t))])
            abc = np.linalg.lstsq(A, s, rcond=None)[0]
            left = float(np.sum((A @ abc - s) ** 2))
            if left < cost:
                best, cost = np.array([abc[0], abc[1], d, f, abc[2]]), left
    return best

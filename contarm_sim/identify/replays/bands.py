"""How far off a fit's prediction may be, by what the fit leaves open: parameters with a covariance, and noise.

Linearised: the prediction is taken to be linear in the parameters within a standard deviation of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.errors import ContarmError
from contarm_sim.identify.freedom import Freedom
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.identify.replays.covariance import Covariance
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

INSIDE = 0.95
"""Share of samples that is meant to be inside a band."""

SQUARED_RADIUS = 7.814728
"""Of an ellipsoid that holds 95 % of a normal distribution in space, in standard deviations (chi square of 3)."""

DRAWS = 400
"""Draws that intervals of the rms are from."""


@dataclass(frozen=True, eq=False, repr=False)
class Bands(Shown):
    """How far a prediction of T samples of K markers may be off if the arm is right.

    Attributes:
        covariance: of each marker's predicted place, by the parameters alone [m^2], shape (T, K, 3, 3).
        noise: of one coordinate [m].
        inside: whether the measured place is inside its 95 % ellipsoid, shape (T, K); False where it was not seen.
        seen: whether it was, shape (T, K).
        rms: 95 % interval of the rms error [m] as the parameters vary.
        foreseen: of the rms error [m] that parameters and noise alone would make.
        held: parameters that count as known though no data determined them.
    """

    covariance: Array
    noise: float
    inside: NDArray[np.bool_]
    seen: NDArray[np.bool_]
    rms: tuple[float, float]
    foreseen: tuple[float, float]
    held: tuple[str, ...] = ()

    @property
    def share(self) -> float:
        """Share of the seen markers that are inside their bands."""
        return float(self.inside[self.seen].mean()) if self.seen.any() else float("nan")

    @property
    def half_width(self) -> Array:
        """Half the width of the 95 % band of each coordinate [m], shape (T, K, 3)."""
        variance = np.diagonal(self.covariance, axis1=-2, axis2=-1) + self.noise**2
        return np.asarray(1.959964 * np.sqrt(variance))


Predict = Callable[[list[Arm], list[Rig]], Array]


def directions(covariance: Covariance) -> Array:
    """Return one standard deviation along each axis of the parameters' ellipsoid, in the vector, shape (P, P)."""
    variances, axes = np.linalg.eigh(0.5 * (covariance.matrix + covariance.matrix.T))
    kept = variances > 1e-12 * max(float(variances.max(initial=0.0)), 1e-300)
    return np.asarray((axes[:, kept] * np.sqrt(variances[kept])).T)


def banded(covariance: Covariance, recording: Recording, nominal: Array, predict: Predict) -> Bands:
    """Return the bands of a recording's prediction.

    Args:
        covariance: of parameters about the arm and the rig of the recording.
        recording: what was measured.
        nominal: where that arm in that rig has the markers [m], shape (T, K, 3).
        predict: where markers are of some arms in their rigs, shape (B, T, K, 3).
    """
    own, steps = covariance.freedom, directions(covariance)
    middle = own.vector(own.values())
    low, high = own.bounds()
    arms, rigs, signs = list[Arm](), list[Rig](), list[float]()
    for step in steps:
        arm, rig, sign = _moved(own, middle, step, low, high)
        arms.append(arm)
        rigs.append(rig)
        signs.append(sign)
    found = predict(arms, rigs) if arms else np.empty((0, *nominal.shape))
    turned = np.array(signs)[:, None, None, None] * (found - nominal)
    moved = np.nan_to_num(turned)  # no pose there: no band from it
    told = np.einsum("ptki,ptkj->tkij", moved, moved)
    error = recording.positions - nominal
    seen = np.asarray(np.isfinite(error).all(axis=-1))
    whole = told + max(covariance.noise, 1e-9) ** 2 * np.eye(3)
    known = np.where(seen[..., None], error, 0.0)
    far = np.einsum("tki,tki->tk", known, np.linalg.solve(whole, known[..., None])[..., 0])
    rms, foreseen = _intervals(known[seen], moved[:, seen], covariance.noise, covariance.noise_sd)
    return Bands(told, covariance.noise, seen & (far <= SQUARED_RADIUS), seen, rms, foreseen, covariance.held)


def _moved(own: Freedom, middle: Array, step: Array, low: Array, high: Array) -> tuple[Arm, Rig, float]:
    """Return an arm in its rig a step away from the middle, or a step the other way where no arm is that way."""
    for sign in (1.0, -1.0):
        vector = middle + sign * step
        if (vector >= low).all() and (vector <= high).all():
            try:
                return *own.applied(own.of_vector(vector)), sign
            except ContarmError:
                continue
    return *own.applied(own.of_vector(np.clip(middle + step, low, high))), 1.0


def _intervals(
    error: Array, moved: Array, noise: float, noise_sd: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return 95 % intervals of the rms as parameters vary, and of the rms that parameters and noise would make [m].

    Args:
        error: measured less predicted of what was seen [m], shape (N, 3).
        moved: what each direction moves there [m], shape (P, N, 3).
        noise, noise_sd: of one coordinate, and how well it is known [m].
    """
    if not len(error):
        return (float("nan"),) * 2, (float("nan"),) * 2
    rng = np.random.default_rng(0)
    draws = rng.standard_normal((DRAWS, len(moved)))
    # |e - S z|^2 and |S z + n|^2 over all samples, from inner products: no draw takes a whole recording
    square = np.einsum("pni,qni->pq", moved, moved)
    along = np.einsum("pni,ni->p", moved, error)
    off = np.einsum("dp,pq,dq->d", draws, square, draws)
    rms = np.sqrt(np.maximum((error**2).sum() - 2 * draws @ along + off, 0.0) / len(error))
    chance = (noise + noise_sd * rng.standard_normal(DRAWS)) ** 2 * rng.chisquare(3 * len(error), DRAWS)
    foreseen = np.sqrt((off + chance) / len(error))
    low, high = np.percentile(rms, (2.5, 97.5)).tolist()
    least, most = np.percentile(foreseen, (2.5, 97.5)).tolist()
    return (low, high), (least, most)

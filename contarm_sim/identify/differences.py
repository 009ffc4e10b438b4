"""How far measured markers are from predicted ones: a few numbers of many differences."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.kinematics.arrays import Array

NAN = float("nan")


@dataclass(frozen=True, repr=False)
class Differences(Shown):
    """Numbers of N differences, measured less predicted [m].

    Attributes:
        count: N, markers that were not seen or not predicted left out.
        rms, median, percentile_95, largest: of their lengths.
        centred_rms: rms of what is left without the mean offset of each marker over these samples.
        bias: their mean, a vector.
    """

    count: int
    rms: float
    median: float
    percentile_95: float
    largest: float
    centred_rms: float
    bias: tuple[float, float, float]

    def to_dict(self) -> dict[str, Any]:
        """Return them as summary.json has them, with the unit in each name."""
        return {
            "markers_seen": self.count, "rms_m": self.rms, "rms_centred_m": self.centred_rms, "median_m": self.median,
            "percentile_95_m": self.percentile_95, "largest_m": self.largest, "bias_m": self.bias,
        }  # fmt: skip


def differences(error: Array) -> Differences:
    """Return the numbers of differences [m] of T samples of K markers, shape (T, K, 3); NaN is left out."""
    seen = np.asarray(np.isfinite(error).all(axis=-1))
    if not seen.any():
        return Differences(0, NAN, NAN, NAN, NAN, NAN, (NAN, NAN, NAN))
    known = np.where(seen[..., None], error, 0.0)
    centred = (error - known.sum(axis=0) / np.maximum(seen.sum(axis=0), 1)[:, None])[seen]
    error = error[seen]
    size = np.linalg.norm(error, axis=1)
    x, y, z = error.mean(axis=0).tolist()
    return Differences(
        len(size), root_mean_square(size), float(np.median(size)), float(np.percentile(size, 95)), float(size.max()),
        root_mean_square(np.linalg.norm(centred, axis=1)), (x, y, z),
    )  # fmt: skip


def root_mean_square(values: Array) -> float:
    """Return the root mean square of numbers, any shape, NaN left out; NaN of none."""
    known = values[np.isfinite(values)]
    return float(np.sqrt((known**2).mean())) if len(known) else NAN

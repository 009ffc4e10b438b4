"""Errors as they are told and drawn: outliers apart, so that a few make neither a verdict nor the scale of a figure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contarm_sim.identify.differences import root_mean_square
from contarm_sim.kinematics.arrays import Array

BEYOND = 6.0
"""Errors beyond this many times their median are outliers."""

FEW = 0.1
"""If more than this share of the errors are beyond, they are no outliers: errors are unlike then."""


SWAYED = 1.2
"""Outliers are told of with the rms if they make it so many times as large."""


def outliers(sizes: Array) -> NDArray[np.bool_]:
    """Return which errors, not below 0, are outliers, in their shape; NaN are none."""
    known = np.isfinite(sizes)
    if not known.any():
        return known
    far = known & (np.nan_to_num(sizes) > BEYOND * float(np.median(sizes[known])))
    return far if far.sum() <= FEW * known.sum() else np.zeros_like(known)


def without(sizes: Array) -> float:
    """Return the root mean square of errors without outliers; NaN of none."""
    return root_mean_square(sizes[~outliers(sizes)])


def swaying(sizes: Array) -> int:
    """Return how many outliers there are, if they make the root mean square much larger than it is without them."""
    return int(outliers(sizes).sum()) if root_mean_square(sizes) > SWAYED * without(sizes) else 0


def reach(sizes: Array) -> tuple[float, int]:
    """Return up to where errors are drawn, and how many are beyond: outliers do not make the rest flat."""
    kept = sizes[np.isfinite(sizes) & ~outliers(sizes)]
    return 1.08 * float(kept.max(initial=0.0)) or 1.0, int(outliers(sizes).sum())


def enlarged(share: float) -> int:
    """Return how often errors are drawn enlarged, the largest of which is so large a share of what is drawn."""
    return next((often for often in (1, 2, 5, 10, 20) if often * share >= 0.08), 20)


def told(count: int, of: str = "") -> str:
    """Return how many outliers there are in words: `one outlier`, `5 outliers`, `5 outliers of 116`."""
    said = "one outlier" if count == 1 else f"{count:,} outliers"
    return f"{said} of {of}" if of else said

"""What the inverse kinematics of several sections returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array

TOLERANCE = 1e-9
"""Miss that counts as reached, as a fraction of the backbone's length; angles count as their arc at 0.3 of it."""

ANGLE_LENGTH = 0.3
"""What an angle of 1 rad counts as, beside a distance, as a fraction of the backbone's length."""


@dataclass(frozen=True)
class Inverse:
    """One answer for each target; arrays share leading axes.

    Attributes:
        bends: of the sections [rad], shape (..., S, 2): the solution chosen, or the nearest found where there is none.
        miss: distance from the target to the tip that `bends` reach [m], shape (...).
        angle_miss: angle between the direction or orientation asked for and the one reached [rad], shape (...); 0 where
            none was asked for.
        reachable: whether both are within the tolerance, shape (...), bool.
        solutions: how many solutions there are within the limits, shape (...); -1 where they are a continuum.
    """

    bends: Array
    miss: Array
    angle_miss: Array
    reachable: NDArray[np.bool_]
    solutions: NDArray[np.intp]

"""What the inverse kinematics of several sections returns, and what counts as reached."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.kinematics.arrays import Array

Index = NDArray[np.intp]
Bool = NDArray[np.bool_]

TOLERANCE = 1e-9
"""Miss that counts as reached, as a fraction of the backbone's length; angles count as their arc at 0.3 of it."""

ANGLE_LENGTH = 0.3
"""What an angle of 1 rad counts as, beside a distance, as a fraction of the backbone's length."""


@dataclass(frozen=True, repr=False)
class Inverse(Shown):
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
    reachable: Bool
    solutions: Index

    def shaped(self, shape: tuple[int, ...]) -> Inverse:
        """Return the same with other leading axes."""
        return Inverse(*(x.reshape((*shape, *x.shape[1:])) for x in self._columns()))

    def replaced(self, rows: Any, other: Inverse) -> Inverse:
        """Return the same with other answers in some rows."""
        out = replace(self, **{f.name: np.array(getattr(self, f.name)) for f in fields(self)})
        for own, new in zip(out._columns(), other._columns(), strict=True):
            own[rows] = new
        return out

    def _columns(self) -> list[Any]:
        return [getattr(self, f.name) for f in fields(Inverse)]

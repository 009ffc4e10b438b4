"""What a controller works from: lengths and controls of all samples, computed beforehand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array


@dataclass(frozen=True)
class Plan:
    """What a controller works from, computed for all samples at once.

    Attributes:
        lengths: muscle lengths asked for [m], shape (T, n).
        setpoint: controls before feedback, shape (T, n): length changes [m], pressures [Pa] or tensions [N].
        start: controls that hold the first sample at rest, shape (n,).
    """

    lengths: Array
    setpoint: Array
    start: Array

    def __post_init__(self) -> None:
        for name in ("lengths", "setpoint", "start"):
            try:
                object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=float))
            except (TypeError, ValueError):
                raise InputError(f"plan.{name}", getattr(self, name), "an array of numbers") from None

    def checked(self, count: int, muscles: int) -> Self:
        """Return the plan, if it is one of so many samples and muscles.

        Raises:
            InputError: arrays of other shapes, or numbers that are not finite.
        """
        shapes = {"lengths": (count, muscles), "setpoint": (count, muscles), "start": (muscles,)}
        for name, shape in shapes.items():
            array = getattr(self, name)
            if np.shape(array) != shape:
                raise InputError(f"plan.{name}", f"of shape {np.shape(array)}", f"an array of shape {shape}")
            if not np.isfinite(array).all():
                raise InputError(f"plan.{name}", "not finite everywhere", "finite numbers")
        return self

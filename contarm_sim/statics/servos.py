"""Length servos at rest: what they would pull without limits, and the energy that their limits take."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.statics.poses import Poses


class Servos:
    """The limited springs of a plant's muscles; without length servos, or unlimited ones, there is nothing to limit."""

    def __init__(self, plant: Plant | Poses) -> None:
        model = plant.model
        self._plant = plant
        self._limited = plant.actuation == "lengths" and bool(model.actuator_forcelimited.all())
        if self._limited:
            self._low, self._high = model.actuator_ctrlrange.T
            gain, bias = model.actuator_gainprm, model.actuator_biasprm
            if isinstance(plant, Poses):
                gain, bias = plant.gain, plant.bias
            self._kp, self._bias = gain[..., 0], bias[..., 0]
            self._most = -model.actuator_forcerange[:, 0]

    def unlimited(self) -> Array:
        """Return the tensions [N], shape (..., M), that servos would have without limits."""
        if not self._limited:
            return np.zeros(self._plant.damping.shape)
        control = self._plant.data.ctrl.clip(self._low, self._high)
        return np.asarray(self._kp * (self._plant.data.actuator_length - control) - self._bias)

    def kinks(self, before: Array, after: Array) -> Any:
        """Return the energy [J], shape (...), that springs take beyond their mean tension times their stretch.

        Args:
            before, after: unlimited tensions [N], shape (..., M).
        """
        if not self._limited:
            return 0.0
        most = self._most
        one, two = before.clip(0.0, most), after.clip(0.0, most)
        inside = 0.5 * (two**2 - one**2) + most * (np.maximum(after - most, 0.0) - np.maximum(before - most, 0.0))
        return ((inside - 0.5 * (one + two) * (after - before)) / self._kp).sum(axis=-1)

"""Length servos at rest: what they would pull without limits, and the energy that their limits take."""

from __future__ import annotations

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array


class Servos:
    """The limited springs of a plant's muscles; without length servos, or unlimited ones, there is nothing to limit."""

    def __init__(self, plant: Plant) -> None:
        model = plant.model
        self._plant = plant
        self._limited = plant.actuation == "lengths" and bool(model.actuator_forcelimited.all())
        if self._limited:
            self._low, self._high = model.actuator_ctrlrange.T
            self._kp, self._bias = model.actuator_gainprm[:, 0], model.actuator_biasprm[:, 0]
            self._most = -model.actuator_forcerange[:, 0]

    def unlimited(self) -> Array:
        """Return the tensions [N], shape (M,), that servos would have without limits."""
        if not self._limited:
            return np.zeros(len(self._plant.damping))
        control = self._plant.data.ctrl.clip(self._low, self._high)
        return np.asarray(self._kp * (self._plant.data.actuator_length - control) - self._bias)

    def kinks(self, before: Array, after: Array) -> float:
        """Return the energy [J] that springs take beyond their mean tension times their stretch.

        Args:
            before, after: unlimited tensions [N], shape (M,).
        """
        if not self._limited:
            return 0.0
        most = self._most
        one, two = before.clip(0.0, most), after.clip(0.0, most)
        inside = 0.5 * (two**2 - one**2) + most * (np.maximum(after - most, 0.0) - np.maximum(before - most, 0.0))
        return float(((inside - 0.5 * (one + two) * (after - before)) / self._kp).sum())

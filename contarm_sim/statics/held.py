"""What holds a pose at rest: the controls that its muscle lengths and tensions mean, if there are such."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.mechanics.pneumatics import force
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.statics.failures import too_much_pressure, too_short, too_strong


class Held:
    """A plant in the pose that is held.

    Attributes:
        plant: the arm.
        tensions: of the actuators, without the silicone's [N], shape (n,).
    """

    plant: Plant
    tensions: Array

    def setpoints(self, checked: bool = True) -> Array:
        """Return the controls of length servos that hold the pose, length changes [m], shape (n,).

        Args:
            checked: refuse what servos cannot follow.

        Raises:
            EquilibriumError: they are out of the servos' range, or take more than the muscles' blocked force.
        """
        arm = self.plant.arm
        control = servo_control(self.plant.muscle_lengths, self.tensions, arm)
        if not checked:
            return control
        limit, (low, high) = self._strongest, self._setpoint_range
        over = int((self.tensions - limit).argmax())
        if self.tensions[over] > limit[over]:
            raise too_strong(muscles.said(self.plant.arm, over), float(limit[over]), float(self.tensions[over]))
        beyond = np.maximum(low - control, control - high)
        worst = int(beyond.argmax())
        if beyond[worst] > 0:
            raise too_short(
                muscles.said(self.plant.arm, worst), float(low[worst]), float(high[worst]), float(control[worst])
            )
        return control

    @cached_property
    def _strongest(self) -> Array:
        """The muscles' blocked forces [N]."""
        return muscles.each(self.plant.arm, lambda group: group.law.blocked_force)

    @cached_property
    def _setpoint_range(self) -> tuple[Array, Array]:
        """The lowest and highest controls of the muscles' length servos [m]."""
        arm = self.plant.arm
        return (
            muscles.each(arm, lambda group: group.setpoint_range[0]),
            muscles.each(arm, lambda group: group.setpoint_range[1]),
        )

    def excess(self) -> float:
        """Return how far the pose is beyond what length servos can hold [N]; 0 if they can."""
        arm = self.plant.arm
        control, (low, high) = servo_control(self.plant.muscle_lengths, self.tensions, arm), self._setpoint_range
        stiffness = muscles.each(arm, lambda group: group.servo_stiffness)
        beyond = np.maximum(low - control, control - high) * stiffness
        return max(0.0, float(beyond.max()), float((self.tensions - self._strongest).max()))

    def pressures(self) -> Array:
        """Return the pressures that hold the pose [Pa], shape (n,).

        Raises:
            EquilibriumError: one is higher than there is.
        """
        arm = self.plant.arm
        per_pascal = force(1.0, self.plant.muscle_lengths, arm)
        pressures = np.divide(self.tensions, per_pascal, out=np.full(len(per_pascal), np.inf), where=per_pascal > 0)
        limit = muscles.each(arm, lambda group: group.pneumatics.max_pressure)
        over = int((pressures - limit).argmax())
        if pressures[over] > limit[over]:
            raise too_much_pressure(muscles.said(self.plant.arm, over), float(limit[over]), float(pressures[over]))
        return pressures

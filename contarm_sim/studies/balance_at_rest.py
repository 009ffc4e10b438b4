"""What pressures must do for the simulated arm to rest in a bend, its own weight and payload bending it too."""

from __future__ import annotations

import numpy as np

from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.errors import EquilibriumError, NotConvergedError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import pneumatics, routing
from contarm_sim.mechanics.pressures import balance_pressure, level_range
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.mechanics.statics import Balance, balance
from contarm_sim.model.arm import Arm
from contarm_sim.statics.solver import Solver

_CORRECTIONS = 20
"""Most corrections of set-points; two or three do."""

_LENGTH, _LEVEL = 1e-8, 1e-2
"""What is left of a length [m], of a tension [N]."""


class RestingBalance:
    """An arm whose servos, which push too, hold muscle lengths: the tensions are those that hold the bend.

    A bend is what muscle lengths show of it, the integral of curvature; between, the arm sags as it will.
    """

    def __init__(self, arm: Arm) -> None:
        self._arm = arm
        self._plant = Plant(arm, pull_only=False)
        self._settle = Solver(self._plant)
        self._tensions: Array | None = None
        self._moved_by_level = arm.path == "spans" or arm.torsional_stiffness is not None

    def balance(self, bend: Array) -> Balance:
        """Return the tensions that hold a bend [rad], shape (2,).

        Where co-contraction moves the arm, the lowest that pressures give.

        Raises:
            EquilibriumError: the arm does not rest there.
        """
        arm, plant = self._arm, self._plant
        uniform = balance(bend, arm)
        wanted = routing.lengths_from_bend(bend, arm)
        if self._tensions is None:  # else a neighbour's pose and tensions
            plant.reset(bend)
            self._tensions = uniform.at(level_range(uniform, arm)[0])
        setpoint, self._tensions = servo_control(wanted, self._tensions, arm), None
        J = routing.length_jacobian(bend, arm)
        bending = J @ np.linalg.pinv(J)  # what of lengths a bend changes; the rest only makes muscles fight
        with engine_room():
            for _ in range(_CORRECTIONS):
                self._settle(setpoint)
                off = bending @ (wanted - plant.muscle_lengths)
                held = self._held(uniform)
                level = level_range(held, arm)[0][0] if self._moved_by_level else np.zeros(())
                if np.abs(off).max() < _LENGTH and abs(level) < _LEVEL:
                    self._tensions = held.tensions
                    return held
                setpoint = setpoint + off - level / arm.servo_stiffness
        left = float(np.abs(off).max())
        reason = f"muscle lengths are still {1e3 * left:.3g} mm off after {_CORRECTIONS} corrections"
        raise NotConvergedError(reason, left, _LENGTH, pose=plant.data.qpos.copy())

    def _held(self, uniform: Balance) -> Balance:
        arm, lengths, tensions = self._arm, self._plant.muscle_lengths, self._plant.actuator_tensions.copy()
        per_pascal = np.where(lengths <= arm.muscle_length_range[1], pneumatics.force_per_pascal(lengths, arm), 0.0)
        highest = uniform.highest - (tensions - uniform.tensions).mean()
        return Balance(tensions, uniform.cocontraction, per_pascal, highest, uniform.own)

    def pressures(self, bend: Array) -> Array:
        """Return the least pressures [Pa] that hold a bend [rad], shape (n,), all muscles inflated.

        They may be more than there are: see `needed`.
        """
        held = self.balance(bend)
        return held.at(level_range(held, self._arm)[0]) / held.per_pascal

    def needed(self, bend: Array) -> tuple[float, float]:
        """Return the highest of them [Pa]: (all muscles inflated, one may be vented); inf where none hold it.

        Servos hold lengths whatever the load; under constant pressures the same pose may be one that the arm leaves.
        """
        try:
            held = self.balance(bend)
        except EquilibriumError:
            return np.inf, np.inf
        if not self._stays(held):
            return np.inf, np.inf
        inflated, vented = balance_pressure(held, self._arm)
        return float(inflated), float(vented)

    def _stays(self, held: Balance) -> bool:
        """Tell whether the pose just balanced is stable under the least pressures that hold it."""
        arm, lengths = self._arm, self._plant.muscle_lengths
        tensions = held.at(level_range(held, arm)[0])
        per_pascal = np.where(held.per_pascal > 0, held.per_pascal, np.inf)
        slopes = pneumatics.force_slope(tensions / per_pascal, lengths, arm) + pneumatics.passive_slope(lengths, arm)
        stiffness = self._settle.stiffness
        stiffness.forces(tensions + pneumatics.passive_tension(lengths, arm))
        K = stiffness.matrix(tensions, slopes)
        return bool(np.linalg.eigvalsh(0.5 * (K + K.T))[0] > 0)

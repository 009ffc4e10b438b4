"""What pressures must do for the simulated arm to rest in a bend, its own weight and payload bending it too."""

from __future__ import annotations

import numpy as np

from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.errors import EquilibriumError, NotConvergedError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles, pneumatics, routing
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.mechanics.statics import Balance, balance
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Muscles
from contarm_sim.statics.solver import Solver
from contarm_sim.studies.needs import by_pressure, highest_pressure, limits, lowest_tensions, needs

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
        twisting = any(section.torsional_stiffness is not None for section in arm.sections)
        self._moved_by_level = twisting or any(group.routing.path == "spans" for group in arm.groups)
        self._gain = muscles.each(arm, lambda group: group.servo_stiffness)
        self._longest = muscles.each(arm, lambda group: group.length_range[1])

    def balance(self, bend: Array) -> Balance:
        """Return the tensions that hold a bend [rad], shape (2 S,).

        Where co-contraction moves the arm, the lowest that muscles give.

        Raises:
            EquilibriumError: the arm does not rest there.
        """
        arm, plant = self._arm, self._plant
        uniform = balance(bend, arm)
        wanted = routing.lengths_from_bend(bend, arm)
        if self._tensions is None:  # else a neighbour's pose and tensions
            plant.reset(bend)
            self._tensions = lowest_tensions(uniform, arm)
        setpoint, self._tensions = servo_control(wanted, self._tensions, arm), None
        J = routing.length_jacobian(bend, arm)
        bending = J @ np.linalg.pinv(J)  # what of lengths a bend changes; the rest only makes muscles fight
        with engine_room():
            for _ in range(_CORRECTIONS):
                self._settle(setpoint)
                off = bending @ (wanted - plant.muscle_lengths)
                held = self._held(uniform)
                level = self._level(held) if self._moved_by_level else np.zeros(len(wanted))
                if np.abs(off).max() < _LENGTH and np.abs(level).max() < _LEVEL:
                    self._tensions = held.tensions
                    return held
                setpoint = setpoint + off - level / self._gain
        left = float(np.abs(off).max())
        reason = f"muscle lengths are still {1e3 * left:.3g} mm off after {_CORRECTIONS} corrections"
        raise NotConvergedError(reason, left, _LENGTH, pose=plant.data.qpos.copy())

    def _level(self, held: Balance) -> Array:
        """Return how far below the lowest level of its section each muscle is [N], shape (n,)."""
        lowest = held.level(limits(held, self._arm)[0])
        return np.repeat(lowest, [own.stop - own.start for own in held.own])

    def _held(self, uniform: Balance) -> Balance:
        arm, lengths, tensions = self._arm, self._plant.muscle_lengths, self._plant.actuator_tensions.copy()
        per_pascal = np.where(lengths <= self._longest, pneumatics.force_per_pascal(lengths, arm), 0.0)
        more = tensions - uniform.tensions
        highest = uniform.highest - np.array([more[own].mean() for own in uniform.own])
        return Balance(tensions, uniform.cocontraction, per_pascal, highest, uniform.own)

    def drive(self, bend: Array) -> Muscles:
        """Return how muscles are driven with the least pressures, or else tensions, that hold a bend [rad], (2 S,).

        All are inflated. Where that takes more pressure than there is, it is the highest: see `needed`.

        Raises:
            EquilibriumError: the arm does not rest there.
        """
        held = self.balance(bend)
        tensions = lowest_tensions(held, self._arm)
        if by_pressure(self._arm):
            pressures, highest = tensions / held.per_pascal, muscles.each(self._arm, highest_pressure)
            pressures = np.where(pressures > highest * (1 + 1e-9), highest, pressures)
            return Muscles(kind="pressures", values=tuple(pressures))
        return Muscles(kind="tensions", values=tuple(tensions))

    def needed(self, bend: Array) -> tuple[float, float]:
        """Return what that takes, see `needs`: (all muscles inflated, one may be vented); inf where nothing holds it.

        Servos hold lengths whatever the load; under constant pressures the same pose may be one that the arm leaves.
        """
        try:
            held = self.balance(bend)
        except EquilibriumError:
            return np.inf, np.inf
        if not self._stays(held):
            return np.inf, np.inf
        inflated, vented = needs(held, self._arm)
        return float(inflated), float(vented)

    def _stays(self, held: Balance) -> bool:
        """Tell whether the pose just balanced is stable under the least pressures that hold it."""
        arm, lengths = self._arm, self._plant.muscle_lengths
        tensions, slopes = lowest_tensions(held, arm), pneumatics.passive_slope(lengths, arm)
        if by_pressure(arm):
            per_pascal = np.where(held.per_pascal > 0, held.per_pascal, np.inf)
            slopes = pneumatics.force_slope(tensions / per_pascal, lengths, arm) + slopes
        stiffness = self._settle.stiffness
        stiffness.forces(tensions + pneumatics.passive_tension(lengths, arm))
        K = stiffness.matrix(tensions, slopes)
        return bool(np.linalg.eigvalsh(0.5 * (K + K.T))[0] > 0)

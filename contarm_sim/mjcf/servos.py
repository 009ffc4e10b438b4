"""Length servos: a control is a length change from the straight arm [m], shortening negative."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco

from contarm_sim.mjcf.actuators import Actuators, add_round
from contarm_sim.mjcf.routing import Strands, counted_from
from contarm_sim.model.muscle_group import MuscleGroup


class LengthServos(Actuators):
    """One servo a muscle, limited to pulling; `MuscleGroup.setpoint` says what its control means.

    The servo's damping belongs to the tendon: as a part of a force that is limited it would vanish at the limit, and
    the servo would hunt between nothing and full force for ever.
    """

    def add(self, spec: mujoco.MjSpec, strands: Sequence[Strands]) -> None:
        """Add one servo for each muscle."""
        for one in strands:
            actuator, group = one.default.actuator, one.group
            actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
            actuator.gainprm[0] = group.servo_stiffness
            actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
            actuator.biasprm[:3] = _bias(group)
            actuator.forcerange = [-group.law.blocked_force, 0.0]
            actuator.forcelimited = True
            actuator.ctrlrange = group.setpoint_range
            actuator.ctrllimited = True
            add_round(spec, one, one.default)

    def straight_control(self, group: MuscleGroup, share: float) -> float:
        """Return a length change [m]: 0 for a share of 1."""
        return float(group.setpoint(group.length, share * group.law.min_tension))

    def stiffest(self, group: MuscleGroup) -> float:
        """Return the servos' gain [N/m]."""
        return group.servo_stiffness

    def damping(self, group: MuscleGroup) -> float:
        """Return the damping along each muscle [N s/m]."""
        return group.servo_stiffness * group.servo_time

    def write(self, model: mujoco.MjModel, muscles: Any, actuators: Any, group: MuscleGroup) -> None:
        """Write gains, biases, ranges and damping."""
        model.actuator_gainprm[actuators, 0] = group.servo_stiffness
        model.actuator_biasprm[actuators, :3] = _bias(group)
        model.actuator_ctrlrange[actuators] = group.setpoint_range
        model.tendon_damping[muscles] = self.damping(group)


def _bias(group: MuscleGroup) -> list[float]:
    """Return the biases: the engine's force, negative in pulling, is gain times control + bias[0] + bias[1] length."""
    return [-group.servo_tension(0.0, counted_from(group)), -group.servo_stiffness, 0.0]

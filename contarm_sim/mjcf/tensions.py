"""Plain forces: a control is a tension [N]."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from contarm_sim.mjcf.actuators import Actuators, add_round
from contarm_sim.mjcf.routing import Strands
from contarm_sim.model.muscle_group import MuscleGroup


class Tensions(Actuators):
    """One actuator a muscle that pulls with its control, at most with the blocked force."""

    def add(self, spec: mujoco.MjSpec, strands: Sequence[Strands]) -> None:
        """Add one actuator for each muscle."""
        for one in strands:
            actuator, blocked = one.default.actuator, one.group.law.blocked_force
            actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
            actuator.gainprm[0] = -1.0
            actuator.forcerange = [-blocked, 0.0]
            actuator.forcelimited = True
            actuator.ctrlrange = [0.0, blocked]
            actuator.ctrllimited = True
            add_round(spec, one, one.default)

    def straight_control(self, group: MuscleGroup, share: float) -> float:
        """Return a tension [N]: the least for a share of 1."""
        return share * group.law.min_tension

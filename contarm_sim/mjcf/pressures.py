"""Muscles driven by pressure: each law has actuators of its own, found here by the law's class."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from contarm_sim.errors import InputError
from contarm_sim.mjcf.actuators import Actuators
from contarm_sim.mjcf.mckibben import McKibbenMuscles
from contarm_sim.mjcf.routing import Strands
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.pneumatic_law import PneumaticLaw, as_pneumatic

LAWS: dict[type[PneumaticLaw], Actuators] = {McKibben: McKibbenMuscles()}
"""Actuators whose control is a gauge pressure [Pa], by the law whose force they have."""


class PressuredMuscles(Actuators):
    """The actuators of the arm's law; all sections must have the same law."""

    states = True

    def add(self, spec: mujoco.MjSpec, strands: Sequence[Strands]) -> None:
        """Add the law's actuators.

        Raises:
            InputError: a law without pressures or without actuators, or sections of different laws.
        """
        found = [_of(one.group) for one in strands]
        if len(set(map(id, found))) > 1:
            laws = {type(one.group.law).__name__ for one in strands}
            raise InputError("laws", ", ".join(sorted(laws)), "one law for pressures")
        if found:
            found[0].add(spec, strands)

    def straight_control(self, group: MuscleGroup, share: float) -> float:
        """Return a pressure [Pa]."""
        return _of(group).straight_control(group, share)

    def stiffest(self, group: MuscleGroup) -> float:
        """Return the law's largest dF/dL [N/m]."""
        return _of(group).stiffest(group)


def _of(group: MuscleGroup) -> Actuators:
    """Return the actuators of a group's law.

    Raises:
        InputError: there are none.
    """
    law = as_pneumatic(group.law)
    found = LAWS.get(type(law))
    if found is None:
        given = f"'pressures' with the law {type(law).__name__}"
        raise InputError("actuation", given, f"lengths, tensions, or a law of {', '.join(k.__name__ for k in LAWS)}")
    return found

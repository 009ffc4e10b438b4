"""What the muscles of an arm pull with, each by the law of its section; lengths [m] and pressures [Pa] of all at once.

Arrays end in an axis of the arm's muscles, section by section. Of an arm of one section they may have any shape that
broadcasts, for all muscles are alike.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import by_group
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.pneumatic_law import PneumaticLaw


def force(pressure: Any, length: Any, arm: Arm) -> Array:
    """Return pulling forces [N] at gauge pressures and lengths.

    Raises:
        InputError: a law that has no pressures.
    """
    return by_group(lambda group, p, x: group.pneumatics.force(p, x, group.rest_length), arm, pressure, length)


def force_per_pascal(length: Any, arm: Arm) -> Array:
    """Return pulling forces by gauge pressure [N/Pa]; 0 for muscles that no pressure drives."""

    def one(group: MuscleGroup, at: Any) -> Array:
        if isinstance(group.law, PneumaticLaw):
            return group.pneumatics.force(1.0, at, group.rest_length)
        return np.zeros(np.shape(at))

    return by_group(one, arm, length)


def force_slope(pressure: Any, length: Any, arm: Arm) -> Array:
    """Return dF/dL [N/m] of `force` at constant pressure.

    Raises:
        InputError: a law that has no pressures.
    """
    return by_group(lambda group, p, x: group.pneumatics.slope(p, x, group.rest_length), arm, pressure, length)


def passive_tension(length: Any, arm: Arm) -> Array:
    """Return tensions [N] of the silicone alone."""
    return by_group(lambda group, *given: group.law.passive_tension(*given, group.rest_length), arm, length)


def passive_slope(length: Any, arm: Arm) -> Array:
    """Return dF/dL [N/m] of `passive_tension`."""
    return by_group(lambda group, *given: group.law.passive_slope(*given, group.rest_length), arm, length)


def pressure_for(tension: Any, length: Any, arm: Arm) -> Array:
    """Return gauge pressures [Pa] that give tensions [N], the silicone's included; inf where none does.

    And inf for muscles that no pressure drives.
    """

    def one(group: MuscleGroup, pull: Any, at: Any) -> Array:
        if isinstance(group.law, PneumaticLaw):
            return group.law.pressure_for(pull, at, group.rest_length)
        return np.full(np.broadcast(pull, at).shape, np.inf)

    return by_group(one, arm, tension, length)

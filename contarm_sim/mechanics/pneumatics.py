"""What the muscles of an arm pull with, each by the law of its section; lengths [m] and pressures [Pa] of all at once.

Arrays end in an axis of the arm's muscles, section by section. Of an arm of one section they may have any shape that
broadcasts, for all muscles are alike.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.pneumatic_law import PneumaticLaw


def force(pressure: Any, length: Any, arm: Arm) -> Array:
    """Return pulling forces [N] at gauge pressures and lengths.

    Raises:
        InputError: a law that has no pressures.
    """
    return _each(lambda group, p, x: group.pneumatics.force(p, x, group.rest_length), arm, pressure, length)


def force_per_pascal(length: Any, arm: Arm) -> Array:
    """Return pulling forces by gauge pressure [N/Pa]; 0 for muscles that no pressure drives."""

    def one(group: MuscleGroup, at: Any) -> Array:
        if isinstance(group.law, PneumaticLaw):
            return group.pneumatics.force(1.0, at, group.rest_length)
        return np.zeros(np.shape(at))

    return _each(one, arm, length)


def force_slope(pressure: Any, length: Any, arm: Arm) -> Array:
    """Return dF/dL [N/m] of `force` at constant pressure.

    Raises:
        InputError: a law that has no pressures.
    """
    return _each(lambda group, p, x: group.pneumatics.slope(p, x, group.rest_length), arm, pressure, length)


def passive_tension(length: Any, arm: Arm) -> Array:
    """Return tensions [N] of the silicone alone."""
    return _each(lambda group, *given: group.law.passive_tension(*given, group.rest_length), arm, length)


def passive_slope(length: Any, arm: Arm) -> Array:
    """Return dF/dL [N/m] of `passive_tension`."""
    return _each(lambda group, *given: group.law.passive_slope(*given, group.rest_length), arm, length)


def pressure_for(tension: Any, length: Any, arm: Arm) -> Array:
    """Return gauge pressures [Pa] that give tensions [N], the silicone's included; inf where none does.

    And inf for muscles that no pressure drives.
    """

    def one(group: MuscleGroup, pull: Any, at: Any) -> Array:
        if isinstance(group.law, PneumaticLaw):
            return group.law.pressure_for(pull, at, group.rest_length)
        return np.full(np.broadcast(pull, at).shape, np.inf)

    return _each(one, arm, tension, length)


def _each(law: Callable[..., Array], arm: Arm, *given: Any) -> Array:
    """Return what the law of each group says of its own muscles.

    Raises:
        InputError: an arm of several groups, and arrays that do not end in an axis of all their muscles.
    """
    groups: tuple[MuscleGroup, ...] = arm.groups
    if len(groups) == 1:
        return law(groups[0], *given)
    arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in given))
    counts = [group.routing.count for group in groups]
    if arrays[0].ndim == 0 or arrays[0].shape[-1] != sum(counts):
        raise InputError("muscles", f"of shape {arrays[0].shape}", f"shape (..., {sum(counts)})")
    if not groups:
        return arrays[0].copy()
    parts = [np.split(array, np.cumsum(counts)[:-1], axis=-1) for array in arrays]
    return np.concatenate([law(group, *own) for group, *own in zip(groups, *parts, strict=True)], axis=-1)

"""One pose of an arm, as people give it to a study, and numbers of its muscles as people read them."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles, shape
from contarm_sim.model.arm import Arm


def one_bend(bend: Any, arm: Arm) -> Array:
    """Return the coordinates of one pose [rad], shape (2 S,), from these or from a bend a section, shape (S, 2).

    Raises:
        InputError: not finite, not one bend a section, or a bend of pi or more.
    """
    count = len(arm.sections)
    if count == 1:
        return arc.one_bend(bend)
    try:
        size = np.asarray(bend, dtype=float).shape
    except (TypeError, ValueError):
        size = (-1,)
    if size not in ((2 * count,), (count, 2)):
        given = f"of shape {size}" if size != (-1,) else "no numbers"
        raise InputError("bend", given, f"a bend for each of {count} sections, shape ({count}, 2) or ({2 * count},)")
    return shape.as_coordinates(bend, arm)


def by_section(values: Array, arm: Arm) -> Array:
    """Return an arm's coordinates, shape (2 S,), as they are for one section, else with an axis for sections."""
    return values if len(arm.sections) == 1 else values.reshape(-1, 2)


def by_group(values: Array, arm: Arm) -> Array | tuple[Array, ...]:
    """Return numbers of all muscles, shape (n,), as they are for one section, else section by section."""
    return values if len(arm.sections) == 1 else tuple(values[own] for own in muscles.slices(arm))

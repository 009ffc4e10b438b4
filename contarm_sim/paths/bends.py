"""Which bends stand for targets of the tip: by the dome for one section, by inverse kinematics for several."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError, UnreachableError
from contarm_sim.kinematics import dome
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm


def directions_of(value: Any, count: int) -> Array:
    """Return directions as unit vectors, shape (count, 3).

    Raises:
        InputError: of another shape, or a direction of no length.
    """
    from contarm_sim.kinematics.inverse.checks import as_directions

    vectors = as_directions(value)
    if vectors.shape != (count, 3):
        raise InputError("direction", f"of shape {vectors.shape}", f"shape ({count}, 3)")
    return vectors


def bends_to(target: Array, direction: Any, arm: Arm, project: dome.Projection, moving: bool) -> Array:
    """Return the bends [rad], shape (T, 2 S), that reach targets [m], shape (T, 3).

    Raises:
        UnreachableError, InputError: as `Reference.from_path` says.
    """
    if len(arm.sections) == 1:
        if direction is not None:
            raise InputError("direction", "given", "none for an arm of one section: its tip's position fixes it")
        return dome.bend_from_tip(target, arm.length, project).bend
    from contarm_sim.kinematics import inverse  # not needed for one section

    if project not in ("refuse", "nearest"):
        raise InputError("project", repr(project), "refuse or nearest, for an arm of several sections")
    form = shape.backbone(arm)
    directions = None if direction is None else directions_of(direction, len(target))
    if directions is not None and len(form) < 3:
        raise InputError("direction", f"given for {len(form)} sections", "one for three sections or more")
    found = (inverse.track if moving else inverse.solve)(target, form, directions)
    tolerance = dome.TOLERANCE * arm.length
    if project == "refuse" and np.any(found.miss > tolerance):
        index = int(np.argmax(found.miss > tolerance))
        reached = shape.position(found.bends[index].reshape(-1), arm)
        raise UnreachableError(
            target[index], float(found.miss[index]), reached, tolerance, index, dome=False, limits=form.limits
        )
    return found.bends.reshape(len(target), -1)

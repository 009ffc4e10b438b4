"""Numbers of an arm's muscles, group by group: arrays end in an axis of all its muscles, section by section."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_group import MuscleGroup


def slices(arm: Arm) -> list[slice]:
    """Return the muscles of each group, as a slice of all."""
    out, first = [], 0
    for group in arm.groups:
        out.append(slice(first, first + group.routing.count))
        first += group.routing.count
    return out


def count(arm: Arm) -> int:
    """Return how many muscles an arm has."""
    return sum(group.routing.count for group in arm.groups)


def each(arm: Arm, of: Callable[[MuscleGroup], float]) -> Array:
    """Return a number of its group for each muscle, shape (n,)."""
    return np.array([of(group) for group in arm.groups for _ in range(group.routing.count)], dtype=float)


def by_group(law: Callable[..., Array], arm: Arm, *given: Any) -> Array:
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


def said(arm: Arm, index: int) -> str:
    """Return what messages call a muscle, by its place among all: of one section, just `a muscle`."""
    if len(arm.sections) > 1:
        for group, own in zip(arm.groups, slices(arm), strict=True):
            if own.start <= index < own.stop:
                return f"muscle {index - own.start + 1} of section {group.section + 1}"
    return "a muscle"


def require_drivable(arm: Arm) -> None:
    """Refuse an arm whose muscles cannot hold every bend: the closed forms need three muscles or more a section.

    Raises:
        InputError: names the section.
    """
    for number, routing in enumerate(arm.routings):
        if routing.count < 3:
            of_section = "" if len(arm.sections) == 1 else f" in section {number + 1}"
            allowed = "three muscles or more, which can hold a bend in any plane"
            raise InputError("muscle.count", f"{routing.count}{of_section}", allowed)

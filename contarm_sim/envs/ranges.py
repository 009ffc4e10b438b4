"""What the numbers of an action span, by mode: each muscle has the range of its section's muscles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.mechanics.statics import holding_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.pneumatic_law import as_pneumatic

PLANES = np.radians(np.arange(0, 360, 15))
"""Planes in which the tensions of the largest bends are sought [rad]."""

SCATTERED = 400
"""Further poses of several sections that are tried, each section bent in a plane of its own."""


def action_range(
    arm: Arm, mode: Literal["bend", "lengths", "tensions", "pressures"], half_turns: float = 1.0
) -> tuple[Array, Array]:
    """Return what -1 and 1 mean for each number of an action, in the mode's unit, two arrays of shape (size,).

    Args:
        half_turns: what lengths reach to within their range, in what a muscle takes of half a turn.

    Raises:
        InputError: an arm that no pulling muscles hold with its sections bent by 170 deg; pressures for muscles that
            have none.
    """
    if mode == "lengths":
        reach = half_turns * _each(arm, half_turn)
        lowest = _each(arm, lambda group: group.setpoint_range[0])
        return np.maximum(lowest, -reach), np.minimum(_each(arm, lambda group: group.setpoint_range[1]), reach)
    if mode == "pressures":
        return _each(arm, _lowest_pressure), _each(arm, _highest_pressure)
    most = holding_tensions(largest_bends(len(arm.sections)), arm).max(axis=0)
    if mode == "tensions":
        own = zip(arm.groups, muscles.slices(arm), strict=True)
        highest = [np.full(part.stop - part.start, most[part].max()) for _, part in own]
        return np.zeros(len(most)), np.minimum(
            np.concatenate(highest), _each(arm, lambda group: group.law.blocked_force)
        )
    bend = np.full(2 * len(arm.sections), arc.LARGEST_BEND)
    return -bend, bend


def largest_bends(count: int) -> Array:
    """Return poses with every section bent by 170 deg [rad], shape (T, 2 S): in one plane, and in scattered planes."""
    bends = np.tile(arc.from_polar(arc.LARGEST_BEND, PLANES), count)
    if count == 1:
        return bends
    return np.concatenate([bends, scattered_bends(count, SCATTERED)])


def scattered_bends(count: int, poses: int) -> Array:
    """Return poses with every section bent by 170 deg, each in a plane of its own [rad], shape (poses, 2 S)."""
    steps = np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0])[:count]  # irrational: turns that never meet again
    planes = 2 * np.pi * steps * np.arange(1, poses + 1)[:, None]
    return arc.from_polar(arc.LARGEST_BEND, planes).reshape(poses, -1)


def _each(arm: Arm, of: Callable[[MuscleGroup], float]) -> Array:
    return muscles.each(arm, of)


def _lowest_pressure(group: MuscleGroup) -> float:
    return as_pneumatic(group.law).min_pressure


def _highest_pressure(group: MuscleGroup) -> float:
    return as_pneumatic(group.law).max_pressure


def half_turn(group: MuscleGroup) -> float:
    """Return what a muscle takes when every section that it runs through bends by half a turn [m]."""
    return np.pi * group.routing.radius * (group.section - group.first + 1)

"""What a balance asks of the muscles, beside what they have: pressures, or of several sections shares of the most."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.mechanics.pressures import balance_pressure, level_range, section_pressures
from contarm_sim.mechanics.statics import Balance, balance, min_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.pneumatic_law import PneumaticLaw


def highest_pressure(group: MuscleGroup) -> float:
    """Return the highest gauge pressure that there is for muscles [Pa]."""
    return group.law.pressure_limits[1]


def by_pressure(arm: Arm) -> bool:
    """Tell whether all muscles have pressures."""
    return all(isinstance(group.law, PneumaticLaw) for group in arm.groups)


def most(arm: Arm) -> float:
    """Return the most that `needs` may be: the highest pressure [Pa] of one section, else 1."""
    return highest_pressure(arm.group) if len(arm.sections) == 1 and by_pressure(arm) else 1.0


def needs(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the most that any muscle needs at least, each of shape (...): (all inflated, one may be vented).

    Of one section with pneumatic muscles pressures [Pa]; else shares of the highest pressure, or of the highest tension
    of muscles without pressures, which are held at their least tension, or one of them slack. inf where nothing does.
    """
    if len(arm.sections) == 1 and by_pressure(arm):
        return balance_pressure(held, arm)
    if by_pressure(arm):
        highest = np.array([highest_pressure(group) for group in arm.groups])
        inflated, vented = section_pressures(held, arm)
        return (inflated / highest).max(axis=-1), (vented / highest).max(axis=-1)
    return _shares(held, arm, min_tensions(arm)), _shares(held, arm, np.zeros(muscles.count(arm)))


def _shares(held: Balance, arm: Arm, least: Array) -> Array:
    """Return the largest share of the highest tension, shape (...), where no muscle pulls less than `least` [N]."""
    level = held.level(least)
    share = (held.at(level) / muscles.each(arm, lambda group: group.law.blocked_force)).max(axis=-1)
    return np.where((level <= held.highest).all(axis=-1), share, np.inf)


def tension_range(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the lowest and highest levels [N], each of shape (..., S), that tensions within the limits give.

    Raises:
        InputError: a muscle would need more than its highest tension; says how much.
    """
    highest = muscles.each(arm, lambda group: group.law.blocked_force)
    low = held.level(min_tensions(arm))
    high = np.minimum(held.from_tip(lambda room: room.min(axis=-1), highest), held.highest)
    if not np.all(low <= high):
        section = int(np.argmax(~(low <= high).reshape(-1, low.shape[-1]).all(axis=0)))
        own = held.own[section]
        needed, allowed = float(held.at(low)[..., own].max()), float(highest[own].min())
        of_section = "" if len(arm.sections) == 1 else f" for the muscles of section {section + 1}"
        raise InputError("bend", f"one that needs {needed:.4g} N", f"at most {allowed:.4g} N{of_section}")
    return low, high


def lowest_tensions(held: Balance, arm: Arm) -> Array:
    """Return the least tensions [N], shape (..., n), that hold; pressures, where there are any, are within limits."""
    return held.at(level_range(held, arm)[0] if by_pressure(arm) else held.level(min_tensions(arm)))


def needs_of(bend: Any, arm: Arm) -> tuple[Array, Array]:
    """Return `needs` of bends [rad], shape (..., 2 S), in closed form."""
    return needs(balance(bend, arm), arm)

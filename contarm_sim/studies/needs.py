"""What a balance asks of the muscles, beside what they have: pressures, or of several sections shares of the most."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.mechanics.pressures import balance_pressure
from contarm_sim.mechanics.statics import Balance, balance, min_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.pneumatic_law import PneumaticLaw

_ROUNDING = 1e-9
"""Of a tension [N]."""


def highest_pressure(group: MuscleGroup) -> float:
    """Return the highest gauge pressure that there is for muscles [Pa]."""
    return group.law.pressure_limits[1]


def _lowest_pressure(group: MuscleGroup) -> float:
    return group.law.pressure_limits[0]


def _pneumatic(group: MuscleGroup) -> bool:
    return isinstance(group.law, PneumaticLaw)


def by_pressure(arm: Arm) -> bool:
    """Tell whether all muscles have pressures."""
    return all(_pneumatic(group) for group in arm.groups)


def any_pressure(arm: Arm) -> bool:
    """Tell whether there are muscles with pressures."""
    return any(_pneumatic(group) for group in arm.groups)


def most(arm: Arm) -> float:
    """Return the most that `needs` may be: the highest pressure [Pa] of one section, else 1."""
    return highest_pressure(arm.group) if len(arm.sections) == 1 and by_pressure(arm) else 1.0


def limits(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the least and the highest tensions [N] of muscles at a balance's lengths, each of shape (..., n).

    Of muscles with pressures by these, and never less than their law's least tension; of others by the law alone.
    """
    lowest, highest = muscles.each(arm, _lowest_pressure), muscles.each(arm, highest_pressure)
    blocked = muscles.each(arm, lambda group: group.law.blocked_force)
    pressed = np.isfinite(highest)
    most = np.where(pressed, np.where(pressed, highest, 0.0) * held.per_pascal, blocked)
    return np.maximum(min_tensions(arm), lowest * held.per_pascal), most


def needs(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the most that any muscle needs at least, each of shape (...): (all inflated, one may be vented).

    Of one section with pneumatic muscles pressures [Pa]; else shares of the highest pressure, or of the highest tension
    of muscles without pressures, which are held at their least tension, or one of a section slack. inf where nothing
    does.
    """
    if len(arm.sections) == 1 and by_pressure(arm):
        return balance_pressure(held, arm)
    inflated, vented = _shares(held, arm)
    return inflated.max(axis=-1), vented.max(axis=-1)


def _shares(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the largest shares of what muscles have, section by section, each of shape (..., S); see `needs`."""
    least, most = limits(held, arm)
    lowest = muscles.each(arm, _lowest_pressure) * held.per_pascal
    with np.errstate(divide="ignore", invalid="ignore"):
        low = held.level(least)
        shares, taut, slack = held.at(low) / most, np.empty_like(low), np.empty_like(low)
        for number, own in enumerate(held.own):
            pulling = (most[..., own] > 0).all(axis=-1)
            possible = pulling & (low[..., number] <= held.highest[..., number])
            taut[..., number] = best = np.where(possible, shares[..., own].max(axis=-1), np.inf)
            # What the muscles of sections beyond pull here is that of their lowest levels.
            tensions = held.at(np.where(np.arange(len(held.own)) == number, 0.0, low))
            free = held.cocontraction[..., number, :]
            for i in range(own.start, own.stop):
                level = -tensions[..., i] / free[..., i]
                asked = tensions + level[..., None] * free
                others = np.delete(asked[..., own], i - own.start, axis=-1)
                enough = np.delete(lowest[..., own], i - own.start, axis=-1)
                allowed = pulling & (others >= enough - _ROUNDING).all(axis=-1) & (level <= held.highest[..., number])
                share = (asked / most)[..., own].max(axis=-1)
                best = np.minimum(best, np.where(allowed, share, np.inf))
            slack[..., number] = best
    return taut, slack


def tension_range(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the lowest and highest levels [N], each of shape (..., S), that `limits` give.

    Raises:
        InputError: a muscle would need more than it has; says how much.
    """
    least, most = limits(held, arm)
    low = held.level(least)
    high = np.minimum(held.from_tip(lambda room: room.min(axis=-1), most), held.highest)
    if not np.all(low <= high):
        section = int(np.argmax(~(low <= high).reshape(-1, low.shape[-1]).all(axis=0)))
        own = held.own[section]
        needed, allowed = float(held.at(low)[..., own].max()), float(most[..., own].min())
        of_section = "" if len(arm.sections) == 1 else f" for the muscles of section {section + 1}"
        raise InputError("bend", f"one that needs {needed:.4g} N", f"at most {allowed:.4g} N{of_section}")
    return low, high


def lowest_tensions(held: Balance, arm: Arm) -> Array:
    """Return the least tensions [N], shape (..., n), that hold; pressures, where there are any, are not too low."""
    return held.at(held.level(limits(held, arm)[0]))


def needs_of(bend: Any, arm: Arm) -> tuple[Array, Array]:
    """Return `needs` of bends [rad], shape (..., 2 S), in closed form."""
    return needs(balance(bend, arm), arm)

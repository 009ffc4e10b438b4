"""Pressures that hold uniform bends, and the highest of the least that do."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError, PressureError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.mechanics.statics import Balance, balance, min_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_group import MuscleGroup


def level_range(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the lowest and highest levels [N], each of shape (..., S), that pressures within the limits give.

    The lowest also keep each law's `min_tension`; the highest stay below what buckles the arm between its disks. Where
    the lowest is higher, no pressures hold the bend.
    """
    lowest, most = (muscles.each(arm, of) for of in (_min_pressure, _max_pressure))
    low = held.level(np.maximum(min_tensions(arm), lowest * held.per_pascal))
    high = held.from_tip(lambda room: room.min(axis=-1), most * held.per_pascal)
    for number, own in enumerate(held.own):
        high[..., number] = np.where(held.per_pascal[..., own].min(axis=-1) > 0, high[..., number], -np.inf)
    return low, np.minimum(high, held.highest)


def _min_pressure(group: MuscleGroup) -> float:
    return group.pneumatics.min_pressure


def _max_pressure(group: MuscleGroup) -> float:
    return group.pneumatics.max_pressure


def pressure_needed(bend: Any, arm: Arm) -> tuple[Array, Array]:
    """Return the highest of the least pressures [Pa] that hold bends, (all muscles inflated, one may be vented).

    Each of shape (...); inf where no pressure does. Inflated muscles have at least the lowest pressure there is, so
    an antagonist that is vented, without any tension, leaves the others less to carry.
    """
    return balance_pressure(balance(bend, arm), arm)


def balance_pressure(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the highest of the least pressures [Pa] that give a balance's tensions, see `pressure_needed`."""
    inflated, least = section_pressures(held, arm)
    return inflated.max(axis=-1), least.max(axis=-1)


def section_pressures(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the same section by section, each of shape (..., S): of the muscles that end with it."""
    inflated, vented = ways_to_hold(held, arm)
    least = inflated.copy()
    for number, own in enumerate(vented):
        for pressure, margin in own:
            least[..., number] = np.minimum(least[..., number], np.where(margin >= 0, pressure, np.inf))
    return inflated, least


def ways_to_hold(held: Balance, arm: Arm) -> tuple[Array, list[list[tuple[Array, Array]]]]:
    """Return the highest of the least pressures [Pa] that give a balance's tensions in each way that there is.

    Returns:
        with all muscles inflated, shape (..., S), inf where none does; and section by section, muscle by muscle, with
        that muscle vented: (the highest pressure of the others, how far the least of them is above the lowest that
        there is), each of shape (...). Below zero, or where it is no number, that way is not there.
    """
    lowest, vented = muscles.each(arm, _min_pressure), []
    with np.errstate(divide="ignore", invalid="ignore"):
        low = level_range(held, arm)[0]
        pressure = held.at(low) / held.per_pascal
        inflated = np.empty_like(low)
        for number, own in enumerate(held.own):
            pulling = (held.per_pascal[..., own] > 0).all(axis=-1)
            possible = pulling & (low[..., number] <= held.highest[..., number])
            inflated[..., number] = np.where(possible, pressure[..., own].max(axis=-1), np.inf)
            # What the muscles of sections beyond pull here is that of their lowest levels.
            tensions = held.at(np.where(np.arange(len(held.own)) == number, 0.0, low))
            free, ways = held.cocontraction[..., number, :], []
            for i in range(own.start, own.stop):
                level = -tensions[..., i] / free[..., i]
                asked = (tensions + level[..., None] * free) / held.per_pascal
                others = np.delete(asked[..., own], i - own.start, axis=-1)
                enough = np.delete(lowest[own], i - own.start)
                margin = np.minimum((others - enough).min(axis=-1), held.highest[..., number] - level)
                there = np.isfinite(others).all(axis=-1) & pulling
                ways.append((others.max(axis=-1), np.where(there, margin, -np.inf)))
            vented.append(ways)
    return inflated, vented


def holding_pressures(bend: Any, arm: Arm, share: float = 0.0, rate: Any = None) -> Array:
    """Return pressures [Pa] that hold a bend, shape (..., n), all between the lowest and the highest there are.

    Args:
        share: co-contraction, from 0 (the least that the limits allow) to 1 (the most).
        rate: velocity of the bend [rad/s], see `balance`.

    Raises:
        InputError: the bend needs more than the highest pressure (a `PressureError`, which says how much), or no
            pressure holds it.
    """
    held = balance(bend, arm, rate)
    low, high = level_range(held, arm)
    refused = ~(low <= high)
    if refused.any():
        raise _refusal(held, low, arm, int(np.argmax(refused.reshape(-1, low.shape[-1]).any(0))))
    return held.at(low + share * (high - low)) / held.per_pascal


def _refusal(held: Balance, low: Array, arm: Arm, number: int) -> InputError:
    """Return what says what the first bend of a section that no pressures hold needs, and what is allowed."""
    group, own = arm.groups[number], held.own[number]
    of_section = "" if len(arm.sections) == 1 else f" for the muscles of section {number + 1}"
    lowest, highest = (pressure / 1e3 for pressure in group.law.pressure_limits)
    pressures = f"{lowest:.4g} to {highest:.4g} kPa{of_section}"
    if not np.all(held.per_pascal[..., own] > 0):
        shortest, longest = (1e3 * length for length in group.length_range)
        return InputError(
            "bend",
            "one that asks a muscle for a length it cannot take",
            f"muscle lengths of {shortest:.1f} to {longest:.1f} mm{of_section}",
        )
    if np.any(low[..., number] > held.highest[..., number]):
        return InputError(
            "bend", f"one that {pressures} buckle the arm at", "a stiffer arm, more links, or less of a bend"
        )
    needed = float((held.at(low) / held.per_pascal)[..., own].max())
    return PressureError(
        "bend",
        f"one that needs {needed / 1e3:.0f} kPa",
        f"bends that {pressures} can hold",
        needed,
    )

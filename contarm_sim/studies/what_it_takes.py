"""What stiffness, mass or payload an arm would need for constant curvature to hold up to a bend."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.results.document import shown_if
from contarm_sim.studies.trusted_bends import Trusted, have_enough, posed, tip_error, tip_errors

LARGEST_FACTOR = 1e4
"""Most that stiffness is multiplied by, or a mass divided by."""

PRECISION = 0.002
"""To what share factors are found; they are rounded to the safe side, to three digits."""

ANGLES = 8
"""Bends up to the wanted one at which the error is looked at, at most."""

_SPARE = 4.0
"""What muscles may pull while a change is looked for, over what they do."""

_LIMITS = ("max_pressure", "max_tension")
"""Fields of muscle laws that say how much a muscle pulls at most."""

Changed = Callable[[float], Arm]
"""Returns the arm with a parameter multiplied by a factor."""


@dataclass(frozen=True)
class Change:
    """One parameter changed until the tip error stays within the bound, or why that cannot be.

    Attributes:
        factor: what the parameter is to be multiplied by; None where that does not help.
        value: the parameter then [SI]; None for several sections that differ.
        peak_tension_n: the largest tension up to the wanted bend then [N].
        peak_pressure_pa: the highest pressure needed then [Pa]; None without pressures, or where none does it.
        muscles_do: whether the muscles have these.
        why_not: why there is no factor.
    """

    factor: float | None
    value: float | None = None
    peak_tension_n: float | None = None
    peak_pressure_pa: float | None = None
    muscles_do: bool | None = None
    why_not: str | None = field(default=None, metadata=shown_if(lambda change: change.why_not is not None))


@dataclass(frozen=True)
class WhatItTakes:
    """What it would take under one load.

    Attributes:
        error_percent: the largest tip error up to the wanted bend as it is [% of length]; None where it has no rest.
        bending_stiffness, mass: of all sections, each changed alone.
        payload: the same; None without one.
        muscles: what muscles would have to do if it is them alone that do not hold the bend; else None.
    """

    error_percent: float | None
    bending_stiffness: Change
    mass: Change
    payload: Change | None = field(metadata=shown_if(lambda takes: takes.payload is not None))
    muscles: Change | None = field(default=None, metadata=shown_if(lambda takes: takes.muscles is not None))


def what_it_takes(found: Trusted, angles: Array, planes: Array, bend: float, within: float) -> WhatItTakes | None:
    """Return what it takes for the tip error to stay within a bound [% of length] up to a bend [rad].

    None where it does.

    Args:
        found: the errors of the arm as it is, at these bend angles and planes [rad].
    """
    arm, below = found.under.arm, angles[angles < bend - 1e-9]
    tried = np.append(below[:: -(-len(below) // (ANGLES - 1))], bend)
    worst = max(tip_error(arm, bend, plane) for plane in planes)
    worst = max(worst, float(found.error_percent[: len(below)].max(initial=0.0)))
    if worst <= within:
        return None
    strong = [float(tip_errors(_strong(arm, 1.0), tried, plane).max()) for plane in planes]
    if max(strong) <= within:
        none = Change(None, why_not="its muscles do not hold the bend")
        held = _held(arm, lambda own: None, 1.0, tried, float(planes[int(np.argmax(strong))]))
        return WhatItTakes(None, none, none, none if arm.payload else None, held)
    free = max(float(tip_errors(_strong(arm.unloaded, 1.0), tried, plane).max()) for plane in planes)
    why = None
    if free > within:
        why = f"without any weight its {arm.links} links alone leave a tip error of {free:.3g} % of length"
        why = "it has no rest there without any weight" if math.isinf(free) else f"{why}: it takes more links"

    def change(changed: Changed, value: Callable[[Arm], float | None], sign: int, otherwise: str) -> Change:
        if why is not None:
            return Change(None, why_not=why)
        factor, plane = _search(lambda x: _strong(changed(x), x), sign, tried, planes, within)
        if factor is None:
            return Change(None, why_not=otherwise)
        factor = _rounded(factor, up=sign > 0)
        return _held(changed(factor), value, factor, tried, plane)

    payload = None
    if arm.payload:
        own_mass = "its own mass alone moves the tip by more than that"
        payload = change(lambda x: replace(arm, payload=x * arm.payload), lambda own: own.payload, -1, own_mass)
    carried = "its payload alone moves the tip by more than that" if arm.payload else "no mass is small enough"
    return WhatItTakes(
        error_percent=worst if math.isfinite(worst) else None,
        bending_stiffness=change(lambda x: _stiffer(arm, x), _common_stiffness, +1, "no stiffness is enough"),
        mass=change(lambda x: _heavier(arm, x), lambda own: own.mass, -1, carried),
        payload=payload,
    )


def _stiffer(arm: Arm, factor: float) -> Arm:
    parts = (replace(part, bending_stiffness=factor * part.bending_stiffness) for part in arm.sections)
    return replace(arm, sections=tuple(parts))


def _heavier(arm: Arm, factor: float) -> Arm:
    return replace(arm, sections=tuple(replace(part, mass=factor * part.mass) for part in arm.sections))


def _common_stiffness(arm: Arm) -> float | None:
    found = {part.bending_stiffness for part in arm.sections}
    return found.pop() if len(found) == 1 else None


def _strong(arm: Arm, factor: float) -> Arm:
    """Return an arm whose muscles may pull as much as it takes, if their law knows a highest pressure or tension.

    What it takes grows with the factor of its stiffness.
    """
    more = _SPARE * max(factor, 1.0)
    laws = []
    for law in arm.laws:
        highest = {name: more * value for name in _LIMITS if (value := getattr(law, name, None)) is not None}
        laws.append(replace(law, **highest))
    return replace(arm, laws=tuple(laws))


def _search(changed: Changed, sign: int, tried: Array, planes: Array, within: float) -> tuple[float | None, float]:
    """Return the factor nearest to 1 at which the error is within the bound in every plane, and the worst plane."""
    watched, factor = [float(planes[0])], 1.0
    for _ in planes:
        try:
            found = _factor(changed, sign, tried, watched, within)
        except InputError:  # beyond what an arm may have
            found = None
        if found is None:
            return None, watched[-1]
        factor = found
        errors = [float(tip_errors(changed(factor), tried, plane).max()) for plane in planes]
        worst = float(planes[int(np.argmax(errors))])
        if max(errors) <= within * (1 + PRECISION) or worst in watched:
            break
        watched.append(worst)
    return factor, worst


def _factor(changed: Changed, sign: int, tried: Array, watched: list[float], within: float) -> float | None:
    def holds(power: float) -> bool:
        return max(float(tip_errors(changed(power**sign), tried, plane).max()) for plane in watched) <= within

    low, high = 1.0, 2.0
    while not holds(high):
        low, high = high, 2 * high
        if high > LARGEST_FACTOR:
            return None
    while high / low > 1 + PRECISION:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return float(high**sign)


def _rounded(factor: float, up: bool) -> float:
    """Return a factor of three digits, rounded up or down."""
    unit = 10.0 ** (math.floor(math.log10(factor)) - 2)
    return float(f"{(math.ceil if up else math.floor)(factor / unit) * unit:.3g}")


def _held(arm: Arm, value: Callable[[Arm], float | None], factor: float, tried: Array, plane: float) -> Change:
    """Return a change that helps, and what it asks of the muscles in a plane."""
    samples = poses_at_rest(
        _strong(arm, factor), Reference.from_bends(posed(arm, tried, np.full(len(tried), plane)), arm)
    )
    pressed = np.isfinite(muscles.each(arm, lambda group: group.law.pressure_limits[1]))
    needed = samples.pressure[:, pressed]
    enough = bool(have_enough(replace(samples, arm=arm)).all())
    peak = float(needed.max()) if pressed.any() and np.isfinite(needed).all() else None
    return Change(factor, value(arm), float(samples.muscle_tensions.max()), peak, enough)

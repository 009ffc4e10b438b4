"""Quantities with units, as people write them: `250mm`, `90deg`, `700 kPa`; bare numbers are SI.

A bare number that is out of proportion for its unit is asked about: people think in millimetres, grams and degrees.
"""

from __future__ import annotations

import math
import re
from fractions import Fraction

from contarm_sim.errors import InputError

_PREFIXES = {"": "1", "k": "1e3", "M": "1e6", "c": "1e-2", "m": "1e-3", "u": "1e-6"}

# Each symbol: what one of it is in SI units, and the powers of (m, kg, s, rad) it has.
_PLAIN: dict[str, tuple[float, tuple[int, ...]]] = {
    "m": (1, (1, 0, 0, 0)),
    "g": (0.001, (0, 1, 0, 0)),
    "s": (1, (0, 0, 1, 0)),
    "N": (1, (1, 1, -2, 0)),
    "Pa": (1, (-1, 1, -2, 0)),
    "bar": (1e5, (-1, 1, -2, 0)),
    "rad": (1, (0, 0, 0, 1)),
}
_ALONE: dict[str, tuple[float, tuple[int, ...]]] = {
    "deg": (math.pi / 180, (0, 0, 0, 1)),
    "°": (math.pi / 180, (0, 0, 0, 1)),
    "psi": (6894.757293168361, (-1, 1, -2, 0)),
    "min": (60, (0, 0, 1, 0)),
    "%": (0.01, (0, 0, 0, 0)),
    "-": (1, (0, 0, 0, 0)),
}
_SYMBOLS = {
    **{prefix + name: (float(Fraction(factor) * Fraction(str(size))), powers)
       for name, (size, powers) in _PLAIN.items() for prefix, factor in _PREFIXES.items()},
    **_ALONE,
}  # fmt: skip
_ONE = re.compile("(" + "|".join(map(re.escape, sorted(_SYMBOLS, key=len, reverse=True))) + r")(?:\^?([1-4]))?[ *·]*")
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:inf|nan))\s*(.*?)\s*", re.IGNORECASE)

EXAMPLES = {
    "m": "250mm", "kg": "50g", "s": "5ms", "rad": "90deg", "Pa": "700kPa", "N": "0.3N", "N m": "20Nmm", "1/m": "2",
    "N m^2": "1e5Nmm^2", "N/m": "2N/mm", "m/s^2": "9.81m/s^2", "-": "0.25 or 25%",
}  # fmt: skip
"""A quantity for every unit of a parameter, as it may be written."""

_USUAL = {
    "m": (10.0, "millimetres", "mm"), "kg": (20.0, "grams", "g"), "s": (3600.0, "milliseconds", "ms"),
    "rad": (2 * math.pi, "degrees", "deg"), "m/s^2": (100.0, "mm/s^2", "mm/s^2"), "N": (1e5, "mN", "mN"),
}  # fmt: skip
"""The largest bare number that is taken as it stands, and the unit that is meant, it seems, by a larger one."""

_LEAST_PRESSURE = 1000.0
"""Pressures [Pa] below this, and not zero, are no muscle's: kPa or bar are meant, it seems."""


def factor(unit: str) -> tuple[float, tuple[int, ...]] | None:
    """Return (what one of a unit is in SI units, its powers of m, kg, s, rad), or None for what is no unit."""
    size, powers = 1.0, [0, 0, 0, 0]
    for place, part in enumerate(unit.strip().split("/")):
        part, sign = part.strip(), -1 if place else 1
        if place == 0 and part == "1":
            continue
        at = 0
        while at < len(part):
            found = _ONE.match(part, at)
            if found is None:
                return None
            one, own = _SYMBOLS[found[1]]
            power = sign * int(found[2] or 1)
            size, powers = size * one**power, [a + power * b for a, b in zip(powers, own, strict=True)]
            at = found.end()
        if not part:
            return None
    return size, tuple(powers)


def quantity(text: str, unit: str, name: str) -> float:
    """Return a number in an SI unit from text: a bare number, or one with a unit of the same kind.

    Raises:
        InputError: not a number, a unit of another kind, or a bare number that asks for its unit.
    """
    allowed = f"a number{'' if unit == '-' else f' [{unit}]'}, or with its unit, such as {EXAMPLES.get(unit, '1')}"
    found = _QUANTITY.fullmatch(text) if len(text) < 100 else None
    if found is None:
        raise InputError(name, repr(text), allowed)
    value, written = float(found[1]), found[2]
    if written:
        size, wanted = factor(written), factor(unit)
        if size is None or wanted is None or size[1] != wanted[1]:
            raise InputError(name, repr(text), allowed)
        exact = size[0] / wanted[0]  # 250 mm is 250/1000, not 250 * 0.001: the nearest number to what was written
        return value / round(1 / exact) if exact < 1 and math.isclose(1 / exact, round(1 / exact)) else value * exact
    asked = slip(value, unit)
    if asked:
        raise InputError(name, text.strip(), asked)
    return value


def slip(value: float, unit: str) -> str | None:
    """Return what to ask about a bare number that is out of proportion for its SI unit, or None."""
    if not abs(value) < 1e300:  # nan, inf, whole numbers of hundreds of digits
        return None
    if unit == "Pa" and 0 < abs(value) < _LEAST_PRESSURE:
        return f"a pressure in Pa; in kPa? write {value:g}kPa (or {value:g}Pa, if that is meant)"
    if unit not in _USUAL or abs(value) <= _USUAL[unit][0]:
        return None
    _, name, symbol = _USUAL[unit]
    return f"a number in {unit}; in {name}? write {value:g}{symbol} (or {value:g}{unit}, if that is meant)"

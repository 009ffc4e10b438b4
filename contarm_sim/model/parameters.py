"""How parameters are declared, with unit, meaning and allowed interval, and checked when a value is made."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping
from dataclasses import field, fields
from numbers import Real
from typing import Any

from contarm_sim.errors import InputError

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

LARGEST = 1e9
"""Largest value of any parameter, in its SI unit: beyond it arithmetic, not mechanics, decides."""

SMALLEST = 1e-9
"""Smallest value other than zero of a parameter that cannot be negative: the engine knows no mass or inertia below
1e-15, and products of smaller numbers lose their digits."""


def number(
    default: float | None,
    unit: str,
    meaning: str,
    *,
    above: float | None = None,
    least: float | None = None,
    below: float | None = None,
) -> Any:
    """Declare a scalar parameter: its default, unit and meaning, and the interval it must lie in."""
    bounds = {"above": above, "least": least, "below": below}
    return field(default=default, metadata={"unit": unit, "help": meaning, "bounds": bounds})


def as_number(value: Any) -> float:
    """Return a real number of Python or NumPy as a float; NaN for anything else, text and booleans among it."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return math.nan
    try:
        return float(value)
    except OverflowError:  # a whole number of hundreds of digits
        return math.inf


def as_numbers(values: Any) -> tuple[float, ...] | None:
    """Return a sequence of finite real numbers as floats; None for anything else."""
    if isinstance(values, (str, bytes, dict, set, frozenset)):
        return None
    try:
        numbers = tuple(as_number(x) for x in values)
    except TypeError:  # not a sequence
        return None
    return numbers if all(map(math.isfinite, numbers)) else None


def check_count(name: str, value: Any, least: int, what: str = "") -> None:
    """Check a number of things.

    Args:
        what: they are, for the message.

    Raises:
        InputError: not a whole number, or fewer than `least`.
    """
    try:
        count = least - 1 if isinstance(value, bool) else operator.index(value)
    except TypeError:
        count = least - 1
    if count < least:
        raise InputError(name, value, f"a whole number{what and f' of {what}'}, at least {least}")


def _allowed(bounds: dict[str, float | None], unit: str) -> str:
    words = {"above": "greater than", "least": "at least", "below": "below"}
    said = [f"{words[key]} {value:g}" for key, value in bounds.items() if value is not None]
    most = [] if bounds["below"] is not None else [f"at most {LARGEST:g}"]
    return f"a finite number, {' and '.join([*said, *most])}{'' if unit == '-' else f' {unit}'}"


def _check_number(owner: Any, name: str, prefix: str, declared: Mapping[str, Any], optional: bool) -> None:
    given, bounds = getattr(owner, name), declared["bounds"]
    if given is None and optional:
        return
    value, above, least, below = as_number(given), bounds["above"], bounds["least"], bounds["below"]
    ok = (above is None or value > above) and (least is None or value >= least) and (below is None or value < below)
    if not (ok and abs(value) <= LARGEST):
        raise InputError(
            prefix + name, repr(given) if isinstance(given, str) else given, _allowed(bounds, declared["unit"])
        )
    if (above == 0 or least == 0) and 0 < value < SMALLEST:
        zero = "0, or " if least == 0 else ""
        raise InputError(prefix + name, given, f"{zero}at least {SMALLEST:g}: less is lost in rounding")
    object.__setattr__(owner, name, value)


def check_numbers(owner: Any, prefix: str = "") -> None:
    """Check all declared scalars of a new frozen value, and make them floats.

    Raises:
        InputError: names the first that is not a finite number in its interval, with the prefix.
    """
    for item in fields(owner):
        if "bounds" in item.metadata:
            _check_number(owner, item.name, prefix, item.metadata, item.default is None)


def check_vector(owner: Any, name: str, size: int) -> None:
    """Check a vector of a new frozen value, and make it a tuple of floats.

    Raises:
        InputError: it has not `size` finite numbers.
    """
    given = getattr(owner, name)
    vector = as_numbers(given)
    if vector is None or len(vector) != size or not all(abs(x) <= LARGEST for x in vector):
        raise InputError(
            name, repr(given) if isinstance(given, str) else given, f"{size} finite numbers, at most {LARGEST:g}"
        )
    object.__setattr__(owner, name, vector)

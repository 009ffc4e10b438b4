"""How parameters are declared, with unit, meaning and allowed interval, and checked when a value is made."""

from __future__ import annotations

import math
from dataclasses import field, fields
from typing import Any

from contarm_sim.errors import InputError

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

LARGEST = 1e9
"""Largest value of any parameter, in its SI unit: beyond it arithmetic, not mechanics, decides."""


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


def _allowed(bounds: dict[str, float | None]) -> str:
    words = {"above": "greater than", "least": "at least", "below": "below"}
    said = [f"{words[key]} {value:g}" for key, value in bounds.items() if value is not None]
    return f"a finite number, {' and '.join([*said, f'at most {LARGEST:g}'])}"


def _check_number(owner: Any, name: str, prefix: str, bounds: dict[str, float | None], optional: bool) -> None:
    value = getattr(owner, name)
    if value is None and optional:
        return
    ok = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    ok = ok and (bounds["above"] is None or value > bounds["above"])
    ok = ok and (bounds["least"] is None or value >= bounds["least"])
    ok = ok and (bounds["below"] is None or value < bounds["below"]) and abs(value) <= LARGEST
    if not ok:
        raise InputError(prefix + name, value, _allowed(bounds))
    object.__setattr__(owner, name, float(value))


def check_numbers(owner: Any, prefix: str = "") -> None:
    """Check all declared scalars of a new frozen value, and make them floats.

    Raises:
        InputError: names the first that is not a finite number in its interval, with the prefix.
    """
    for item in fields(owner):
        if "bounds" in item.metadata:
            _check_number(owner, item.name, prefix, item.metadata["bounds"], item.default is None)


def check_vector(owner: Any, name: str, size: int) -> None:
    """Check a vector of a new frozen value, and make it a tuple of floats.

    Raises:
        InputError: it has not `size` finite numbers.
    """
    value = getattr(owner, name)
    try:
        vector = () if isinstance(value, (str, dict)) else tuple(float(x) for x in value)
    except (TypeError, ValueError):
        vector = ()
    if len(vector) != size or not all(abs(x) <= LARGEST for x in vector):
        raise InputError(name, value, f"{size} finite numbers, at most {LARGEST:g}")
    object.__setattr__(owner, name, vector)

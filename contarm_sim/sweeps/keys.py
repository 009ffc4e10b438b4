"""Tables of TOML files as sweeps and sampled arms have them: full names of parameters, whole numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from contarm_sim.errors import InputError

_LEAF = {"from", "to", "count", "scale", "values", "distribution", "mean", "std", "low", "high", "least", "most"}


def whole_number(name: str, given: Any, least: int, most: int) -> int:
    """Return a whole number within limits.

    Raises:
        InputError: it is none.
    """
    if isinstance(given, bool) or not isinstance(given, int) or not least <= given <= most:
        raise InputError(name, given, f"a whole number from {least} to {most:,}")
    return given


def by_full_names(table: Any, where: str, known: Iterable[str], front: str = "") -> dict[str, Any]:
    """Return a table by full names of parameters: TOML makes a table of `muscle.wall`.

    Raises:
        InputError: it is no table.
    """
    if not isinstance(table, Mapping):
        raise InputError(where, table, f"a table: [{where}]")
    found: dict[str, Any] = {}
    for key, value in table.items():
        name = f"{front}{key}"
        if isinstance(value, Mapping) and value and _of_names(name, value, known):
            found |= by_full_names(value, where, known, f"{name}.")
        else:
            found[name] = value
    return found


def _of_names(front: str, table: Mapping[str, Any], known: Iterable[str]) -> bool:
    """Tell a table of names, such as muscle = { wall = ..., count = ... }, from what one parameter may be."""
    names = [f"{front}.{key}" for key in table]
    known_ones = all(any(f"{other}.".startswith(f"{name}.") for other in known) for name in names)
    return known_ones or not _LEAF & set(table)

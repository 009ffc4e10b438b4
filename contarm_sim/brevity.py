"""Values in a few characters: numbers with four digits, and the calls that make them without what is usual."""

from __future__ import annotations

from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any

from contarm_sim.errors import one_line


class Told:
    """A dataclass whose text is the call that makes it, without the arguments that are its defaults.

    Declare it with `repr=False`, or the dataclass brings a text of its own.
    """

    def __repr__(self) -> str:
        return call(self)


def brief(value: Any) -> str:
    """Return a value in a few characters: numbers with four digits, arrays and collections by their size."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, str):
        return repr(one_line(value, 60))
    if hasattr(value, "shape") and hasattr(value, "tolist"):
        return _array(value)
    if is_dataclass(value):
        return f"{type(value).__name__}(...)"
    if isinstance(value, dict):
        return f"{len(value)} named: {one_line(', '.join(map(str, value)), 60)}"
    if isinstance(value, (tuple, list)):
        plain = len(value) <= 6 and all(isinstance(each, (int, float, str)) for each in value)
        return f"({', '.join(map(brief, value))})" if plain else f"{len(value)} of {type(value[0]).__name__}"
    return one_line(repr(value), 60)


def _array(value: Any) -> str:
    if value.ndim == 0:
        return brief(value.item())
    if value.size <= 6:
        return "[" + ", ".join(map(brief, value.ravel().tolist())) + "]"
    return f"an array of shape {value.shape}"


def call(value: Any) -> str:
    """Return the expression that makes a dataclass again, without the arguments that are its defaults."""
    if isinstance(value, tuple):
        return f"({', '.join(map(call, value))}{',' if len(value) == 1 else ''})"
    if not is_dataclass(value) or isinstance(value, type):
        return repr(value)
    given = [f"{item.name}={call(getattr(value, item.name))}" for item in differing(value)]
    return f"{type(value).__name__}({', '.join(given)})"


def differing(value: Any) -> list[Field[Any]]:
    """Return the fields of a dataclass that are not at their defaults."""
    return [item for item in fields(value) if item.init and getattr(value, item.name) != _default(item)]


def _default(item: Field[Any]) -> Any:
    return item.default if item.default_factory is MISSING else item.default_factory()

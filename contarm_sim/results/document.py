"""A result as a plain document: what `--json` prints and summary.json holds.

A frozen dataclass becomes a dict of its fields, in their order and under their names. Where the document is flatter or
shorter than the dataclass, the field's metadata says so: `INLINE`, `HIDDEN`, `shown_if`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_to_dict

INLINE = {"document": "inline"}
"""Metadata of a field whose own entries stand beside those of its owner; nothing, where the field is None."""

HIDDEN = {"document": "hidden"}
"""Metadata of a field that the document leaves out: an array of samples, say, which has a file of its own."""


def shown_if(condition: Callable[[Any], bool]) -> dict[str, Any]:
    """Return the metadata of a field that is in the document where a condition on its owner holds."""
    return {"document": condition}


def document(value: Any) -> Any:
    """Return a result as plain values that strict JSON can hold.

    Dataclasses and mappings become dicts, an `Arm` its parameters, arrays and sequences lists; numbers that are not
    finite become None.

    Raises:
        TypeError: a value of another kind.
    """
    if isinstance(value, Arm):
        return arm_to_dict(value)
    if is_dataclass(value) and not isinstance(value, type):
        return _of_fields(value)
    if isinstance(value, Mapping):
        return {str(key): document(each) for key, each in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        whole = value.dtype.kind != "f" or bool(np.isfinite(value).all())
        return value.tolist() if whole else document(value.tolist())
    if isinstance(value, list | tuple):
        return [document(each) for each in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | int):
        return value
    raise TypeError(f"{type(value).__name__} has no plain form")


def _of_fields(owner: Any) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for item in fields(owner):
        rule, value = item.metadata.get("document"), getattr(owner, item.name)
        if rule == "hidden" or (callable(rule) and not rule(owner)):
            continue
        if rule == "inline":
            made |= {} if value is None else document(value)
        else:
            made[item.name] = document(value)
    return made

"""What changes from episode to episode, in composer's own way: a value, or a callable of (initial, current, random).

Names are parameters of `Arm`, such as `mass` and `gravity`, those of the muscles' law with `muscle.` in front, and what
a task draws: `target` of reach, `max_bend` of track, `bend` and `force` of hold, and so on. Of an arm of several
sections, those of a section have its name in front, as in `section_2.mass` and `section_2.muscle.braid_friction`;
gravity and payload are the arm's.
dm_control.composer.variation.distributions work unchanged in every front end; so does

    lambda initial_value, current_value, random_state: random_state.uniform(0, 0.1)
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import fields, replace
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.model.section_tables import said_of

_WORLD = ("payload", "gravity")
_SECTION = ("mass", "bending_stiffness", "damping_time", "joint_friction")
_LAW = ("braid_friction", "passive_stiffness", "valve_time", "friction")
"""Parameters that may vary: those that leave the model's structure and the meaning of actions alone. A law has some."""

_Part = tuple[str, int]
"""A field of `Arm`, and a number in it."""


def _parts(arm: Arm) -> dict[str, tuple[_Part, str]]:
    """Return, by the names of what may vary, the part of the arm that has it and its field."""
    found: dict[str, tuple[_Part, str]] = {field: (("world", 0), field) for field in _WORLD}
    for number, law in enumerate(arm.laws):
        before = f"section_{number + 1}." if len(arm.laws) > 1 else ""
        found |= {before + field: (("sections", number), field) for field in _SECTION}
        for item in fields(law):
            if item.name in _LAW:
                found[f"{before}muscle.{item.name}"] = (("laws", number), item.name)
    return found


def varied(arm: Arm) -> tuple[str, ...]:
    """Return the names of the parameters of an arm that may vary."""
    return tuple(_parts(arm))


def check(variations: Mapping[str, Any] | None, drawn: tuple[str, ...], arm: Arm) -> dict[str, Any]:
    """Return the variations as a dict.

    Args:
        drawn: what the task draws.
        arm: the arm without variations.

    Raises:
        InputError: a name that nothing here has.
    """
    known = (*drawn, *varied(arm))
    if variations is not None and not isinstance(variations, Mapping):
        raise InputError("variations", variations, "a dict by names: " + ", ".join(known))
    for name in variations or {}:
        if name not in known:
            raise InputError(f"variation {name!r}", "unknown", ", ".join(known))
    return dict(variations or {})


def evaluate(variation: Any, initial: Any, current: Any, random: np.random.RandomState) -> Any:
    """Return a varied value as plain numbers."""
    value = variation(initial, current, random) if callable(variation) else variation
    return np.asarray(value).tolist() if value is not None else None


def varied_arm(variations: Mapping[str, Any], arm: Arm, current: Arm, random: np.random.RandomState) -> Arm:
    """Return the arm of the next episode.

    Args:
        arm: the arm without variations.
        current: the arm of the last episode.

    Raises:
        InputError: a value that an arm cannot have.
    """
    parts = _parts(arm)
    changed: dict[_Part, dict[str, Any]] = {}
    for name in [name for name in variations if name in parts]:
        part, field = parts[name]
        initial, now = (getattr(_part(one, part), field) for one in (arm, current))
        value = evaluate(variations[name], initial, now, random)
        changed.setdefault(part, {})[field] = value
    if not changed:
        return arm
    made: dict[str, list[Any]] = {"sections": list(arm.sections), "laws": list(arm.laws), "world": [arm.world]}
    for (kind, number), values in changed.items():
        with said_of(number) if len(arm.sections) > 1 and kind != "world" else nullcontext():
            made[kind][number] = replace(made[kind][number], **values)
    return replace(arm, sections=tuple(made["sections"]), laws=tuple(made["laws"]), world=made["world"][0])


def _part(arm: Arm, part: _Part) -> Any:
    kind, number = part
    return arm.world if kind == "world" else getattr(arm, kind)[number]

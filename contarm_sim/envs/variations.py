"""What changes from episode to episode, in composer's own way: a value, or a callable of (initial, current, random).

Names are parameters of `Arm` (`VARIED`), and what a task draws: `target` of reach, `max_bend` of track, `bend` and
`force` of hold, and so on. Of an arm of several sections, those of a section have its name in front, as in
`section_2.mass` and `section_2.muscle.braid_friction`; gravity and payload are the arm's.
dm_control.composer.variation.distributions work unchanged in every front end; so does

    lambda initial_value, current_value, random_state: random_state.uniform(0, 0.1)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_from_dict

VARIED = (
    "mass",
    "payload",
    "bending_stiffness",
    "damping_time",
    "joint_friction",
    "gravity",
    "muscle.braid_friction",
    "muscle.passive_stiffness",
    "muscle.valve_time",
)
"""Parameters of the arm that may vary: those that leave the model's structure and the meaning of actions alone."""

_WORLD = ("payload", "gravity")


def varied(arm: Arm) -> tuple[str, ...]:
    """Return the names of the parameters of an arm that may vary."""
    if len(arm.sections) == 1:
        return VARIED
    found = list(_WORLD)
    for number, law in enumerate(arm.laws):
        for name in (*VARIED, "muscle.friction"):
            place, _, field = name.rpartition(".")
            if name not in _WORLD and (not place or field in {item.name for item in fields(law)}):
                found.append(f"section_{number + 1}.{name}")
    return tuple(found)


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
    if len(arm.sections) > 1:
        return _varied_sections(variations, arm, current, random)
    own: dict[str, Any] = {}
    muscle: dict[str, Any] = {}
    for name, variation in variations.items():
        if name in VARIED:
            place, _, field = name.rpartition(".")
            owner, now = (arm.muscle, current.muscle) if place else (arm, current)
            if not hasattr(owner, field):
                raise InputError(
                    f"variation {name!r}", f"of a {type(owner).__name__}, which has none", "a parameter of it"
                )
            value = evaluate(variation, getattr(owner, field), getattr(now, field), random)
            (muscle if place else own)[field] = value
    return arm_from_dict({**own, "muscle": muscle}, base=arm) if own or muscle else arm


def _varied_sections(variations: Mapping[str, Any], arm: Arm, current: Arm, random: np.random.RandomState) -> Arm:
    """Return the next arm of several sections; what does not vary is that of `arm`."""
    changed: dict[tuple[str, int], dict[str, Any]] = {}
    for name in [name for name in variations if name in varied(arm)]:
        place, _, field = name.rpartition(".")
        section, _, muscle = place.partition(".")
        kind = "laws" if muscle else "sections" if section else "world"
        number = int(section.removeprefix("section_")) - 1 if section else 0
        owner, now = _part(arm, kind, number), _part(current, kind, number)
        value = evaluate(variations[name], getattr(owner, field), getattr(now, field), random)
        changed.setdefault((kind, number), {})[field] = value
    made: dict[str, list[Any]] = {"sections": list(arm.sections), "laws": list(arm.laws), "world": [arm.world]}
    for (kind, number), values in changed.items():
        made[kind][number] = replace(made[kind][number], **values)
    return replace(arm, sections=tuple(made["sections"]), laws=tuple(made["laws"]), world=made["world"][0])


def _part(arm: Arm, kind: str, number: int) -> Any:
    part = getattr(arm, kind)
    return part if kind == "world" else part[number]

"""What changes from episode to episode, in composer's own way: a value, or a callable of (initial, current, random).

Names are parameters of `Arm` (`VARIED`), and what a task draws: `target` of reach, `max_bend` of track, `bend` and
`force` of hold, and so on. dm_control.composer.variation.distributions work unchanged in every front end; so does

    lambda initial_value, current_value, random_state: random_state.uniform(0, 0.1)
"""

from __future__ import annotations

from collections.abc import Mapping
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


def check(variations: Mapping[str, Any] | None, drawn: tuple[str, ...]) -> dict[str, Any]:
    """Return the variations as a dict.

    Args:
        drawn: what the task draws.

    Raises:
        InputError: a name that nothing here has.
    """
    known = (*drawn, *VARIED)
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

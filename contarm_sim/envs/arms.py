"""Whose environment it is: an arm as people name it, and what loads it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import load_arm
from contarm_sim.model.presets import PRESETS, preset

ArmLike = Arm | str | Path
"""An arm, the name of a preset, or a TOML file."""


def as_arm(arm: ArmLike | None = None, gravity: Any = None, payload: Any = None) -> Arm:
    """Return the arm that is meant.

    Args:
        arm: an arm, the name of a preset (paper, two, three, tendon), or the path of a TOML file; default the paper's.
        gravity: in the base frame [m/s^2], shape (3,), in place of the arm's own; (0, 0, 9.81) hangs the arm.
        payload: at the tip [kg], in place of the arm's own.

    Raises:
        InputError: none of these, a file that holds no arm, or a load that cannot be.
    """
    found = _found(Arm() if arm is None else arm)
    if found.world.host is not None:
        allowed = "none: environments have arms on a base of their own; in Python, step the model of arm_spec(arm)"
        raise InputError("world", repr(found.world.host.file), allowed)
    given = {name: value for name, value in (("gravity", gravity), ("payload", payload)) if value is not None}
    return found.in_world(replace(found.world, **given)) if given else found


def _found(arm: Any) -> Arm:
    if isinstance(arm, Arm):
        return arm
    if isinstance(arm, str) and arm in PRESETS:
        return preset(arm)
    if isinstance(arm, Path) or (isinstance(arm, str) and arm.endswith(".toml")):
        return load_arm(arm)
    allowed = f"an Arm, a preset ({', '.join(PRESETS)}), or a file that ends in .toml"
    raise InputError("arm", repr(arm) if isinstance(arm, str) else arm, allowed)

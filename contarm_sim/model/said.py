"""An arm as the expression that makes it: short, for what is as in the paper's arm is left out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from contarm_sim.brevity import call, differing

if TYPE_CHECKING:
    from contarm_sim.model.arm import Arm

_FLAT = {"radius": "muscle_radius", "path": "path"}
"""Parameters of a routing that `Arm` takes beside those of its section and world, and their names there."""


def said(arm: Arm) -> str:
    """Return the call of `Arm` that makes an arm, without what is at its default."""
    one = len(arm.sections) == 1 and {item.name for item in differing(arm.routings[0])} <= set(_FLAT)
    return f"Arm({', '.join(_flat(arm) if one else _nested(arm))})"


def _flat(arm: Arm) -> list[str]:
    """Return the arguments of an arm of one section."""
    section, routing, law, usual = arm.sections[0], arm.routings[0], arm.laws[0], _usual()
    given = [f"{item.name}={call(getattr(section, item.name))}" for item in differing(section)]
    given += [f"{_FLAT[item.name]}={call(getattr(routing, item.name))}" for item in differing(routing)]
    given += [] if law == usual.laws[0] else [f"muscle={call(law)}"]
    return given + [f"{item.name}={call(getattr(arm.world, item.name))}" for item in differing(arm.world)]


def _nested(arm: Arm) -> list[str]:
    """Return the arguments of any arm: its parts."""
    usual, count = _usual(), len(arm.sections)
    parts = {name: getattr(arm, name) for name in ("sections", "routings", "laws", "world")}
    alike = {name: getattr(usual, name) if name == "world" else getattr(usual, name) * count for name in parts}
    keep = {name: part for name, part in parts.items() if part != alike[name] or (name == "sections" and count > 1)}
    return [f"{name}={call(part)}" for name, part in keep.items()]


def _usual() -> Arm:
    from contarm_sim.model.arm import Arm

    return Arm()

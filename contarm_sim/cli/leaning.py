"""What `contarm equilibrium` says of the objects that an arm leans on."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contarm_sim import studies
    from contarm_sim.model.arm import Arm


MANY = 3
"""Contacts with one object, beyond which their sum is said too."""


def leaning(case: studies.CaseAtRest, arm: Arm) -> Iterator[str]:
    """Return lines on contacts, on friction and on free objects; none of an arm that has nothing to touch."""
    if not arm.world.touchable:
        return
    if not case.contacts:
        yield "touches no object" if arm.world.host is None else "touches nothing"
    for name, count in Counter(touch.object for touch in case.contacts).items():
        if count > MANY:
            total = sum(touch.force for touch in case.contacts if touch.object == name)
            yield f"leans on {name} in {count} places, with {total:.4g} N in all:"
    for touch in case.contacts:
        place = "  ".join(f"{round(1e3 * x, 1) + 0.0:.1f}" for x in touch.point)
        yield f"leans on {touch.object} with {touch.force:.4g} N at {100 * touch.xi:.1f} % of its length, at {place} mm"
    if case.friction_range is not None:
        yield _friction(case, case.friction_range)
    host = arm.world.host
    for name in dict.fromkeys(touch.object for touch in case.contacts if host is not None):
        if name in host.read.bodies and host.read.bodies[name].moves:  # type: ignore[union-attr]
            yield f"{name}, which can move, is held where the world starts, whatever that takes"
    for held in case.held_objects:
        force = "  ".join(f"{round(x, 6) + 0.0:.3g}" for x in held.force)
        yield f"{held.name} is held where it stands, by a force of {force} N, its weight included"


def _friction(case: studies.CaseAtRest, most: float) -> str:
    """Say how far friction could hold the tip from there."""
    rough = " and ".join(dict.fromkeys(f"{touch.friction:g}" for touch in case.contacts))
    if most == 0:
        return "contacts are rigid and without friction"
    pose = f"contacts are rigid, and without friction here; with their friction coefficient of {rough} the tip"
    if math.isinf(most):
        return f"{pose} may rest far from this pose; how far is not known to the first order"
    return f"{pose} may rest in a range about this pose, up to about {1e3 * most:.2g} mm away"

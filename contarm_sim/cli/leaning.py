"""What `contarm equilibrium` says of the objects that an arm leans on."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contarm_sim import studies
    from contarm_sim.model.arm import Arm


def leaning(case: studies.CaseAtRest, arm: Arm) -> Iterator[str]:
    """Return lines on contacts, on friction and on free objects; none of an arm that has nothing to touch."""
    if not arm.world.touchable:
        return
    if not case.contacts:
        yield "touches no object" if arm.world.host is None else "touches nothing"
    for touch in case.contacts:
        place = "  ".join(f"{round(1e3 * x, 1) + 0.0:.1f}" for x in touch.point)
        yield f"leans on {touch.object} with {touch.force:.4g} N at {100 * touch.xi:.1f} % of its length, at {place} mm"
    if case.friction_range is not None:
        yield _friction(case, arm, case.friction_range)
    for held in case.held_objects:
        force = "  ".join(f"{round(x, 6) + 0.0:.3g}" for x in held.force)
        yield f"{held.name} is held where it stands, which takes a force of {force} N"


def _friction(case: studies.CaseAtRest, arm: Arm, most: float) -> str:
    """Say how far friction could hold the tip from there."""
    touched = {touch.object for touch in case.contacts}
    rough = " and ".join(dict.fromkeys(f"{each.friction:g}" for each in arm.world.objects if each.name in touched))
    if most == 0:
        return "contacts are rigid and without friction"
    rough = f"their friction coefficient of {rough}" if rough else "friction"
    pose = f"contacts are rigid, and without friction here; with {rough} the tip"
    if math.isinf(most):
        return f"{pose} may rest in a wide range about this pose, which no first order tells"
    return f"{pose} may rest in a range about this pose, up to about {1e3 * most:.2g} mm away"

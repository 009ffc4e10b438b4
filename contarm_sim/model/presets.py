"""Arms to begin with: the paper's, and arms of two and three sections with pneumatic muscles or tendons.

All but the paper's hang: gravity points along the straight arm. Their sizes are this project's own, such that muscles
hold every section bent by up to 90 deg in any plane, by themselves and with the weight of what is beyond.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.tendon import Tendon
from contarm_sim.model.world import World

HANGING = World(gravity=(0.0, 0.0, 9.81))


def paper() -> Arm:
    """Return the paper's arm: one section, three pneumatic muscles, no gravity."""
    return Arm()


def two() -> Arm:
    """Return a hanging arm of two sections, each with three pneumatic muscles of its own."""
    return Arm(
        sections=(
            Section(length=0.20, links=12, mass=0.10, bending_stiffness=0.04),
            Section(length=0.17, links=12, mass=0.06, bending_stiffness=0.02),
        ),
        routings=(Routing(radius=0.014), Routing(radius=0.013)),
        world=HANGING,
    )


def three() -> Arm:
    """Return a hanging arm of three sections, each with three pneumatic muscles of its own."""
    return Arm(
        sections=(
            Section(length=0.20, links=12, mass=0.08, bending_stiffness=0.03),
            Section(length=0.17, links=12, mass=0.05, bending_stiffness=0.02),
            Section(length=0.15, links=12, mass=0.04, bending_stiffness=0.01),
        ),
        routings=(Routing(radius=0.014), Routing(radius=0.013), Routing(radius=0.012)),
        world=HANGING,
    )


def tendon() -> Arm:
    """Return a hanging arm of three sections driven by nine tendons, evenly around it, all from the arm's base."""
    turn = 2 * math.pi / 9
    return Arm(
        sections=(
            Section(length=0.20, links=12, mass=0.10, bending_stiffness=0.05),
            Section(length=0.17, links=12, mass=0.07, bending_stiffness=0.03),
            Section(length=0.14, links=12, mass=0.05, bending_stiffness=0.02),
        ),
        routings=tuple(Routing(offset=number * turn, start="base") for number in range(3)),
        laws=(Tendon(diameter=0.002),) * 3,  # in sheaths of 2 mm
        world=HANGING,
    )


PRESETS: dict[str, Callable[[], Arm]] = {"paper": paper, "two": two, "three": three, "tendon": tendon}
"""The arms by the names that `--preset` takes."""


def preset(name: str) -> Arm:
    """Return the arm of a name.

    Raises:
        InputError: there is none.
    """
    if name not in PRESETS:
        raise InputError("preset", repr(name), ", ".join(PRESETS))
    return PRESETS[name]()

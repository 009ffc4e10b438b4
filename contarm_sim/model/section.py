"""A section of the arm: an inextensible backbone of one stiffness, as a chain of rigid links."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, field

from contarm_sim.brevity import Told
from contarm_sim.errors import InputError
from contarm_sim.model.parameters import check_numbers, number

MAX_SECTIONS = 6
"""Most sections of an arm."""

MAX_LINKS = 400
"""Most links of an arm."""

SHORTEST = 1e-3
"""Shortest section [m]: less is no continuum, and its links are beyond what the engine can turn."""

LONGEST = 1e4
"""Length that sections are below [m]: beyond it the engine loses their links in rounding."""

GUIDE = 1 / math.sqrt(6)
"""Height of a link's guide above its middle [link pitches], where muscles run in straight spans.

A rod bent by beta between two disks shortens a straight span by h beta^2/24 beside r beta; a joint between guides a
below and b above it does so by a b/(2 h) beta^2. Both are the same for a b = h^2/12, which is here.
"""


@dataclass(frozen=True, kw_only=True, repr=False)
class Section(Told):
    """One inextensible section. SI units, checked at construction.

    Friction in the backbone is a spring of `friction_stiffness` in series with a slider that gives way at
    `friction_moment` (an element of Jenkins; elastic and perfectly plastic): its moment z follows the curvature k by
    dz = friction_stiffness dk, and |z| stays at friction_moment where it would be more; both are vectors across the
    backbone. It remembers: what it holds depends on the way to a pose.

    Raises:
        InputError: a parameter is not a finite number in its stated interval, or one alone of the two of friction.
    """

    length: float = number(0.37, "m", "backbone length L0 (paper)", least=SHORTEST, below=LONGEST)
    links: int = field(
        default=24, metadata={"unit": "-", "help": f"joints of the rigid-link backbone, 2 to {MAX_LINKS}"}
    )
    mass: float = number(
        0.3, "kg", "mass of the section (of the whole arm, if it is the only one), spread evenly", above=0
    )
    bending_stiffness: float = number(0.1, "N m^2", "EI of backbone and passive muscles", above=0)
    torsional_stiffness: float | None = number(None, "N m^2", "GJ; omitted: rigid, as the paper claims", above=0)
    damping_time: float = number(0.05, "s", "Kelvin-Voigt time: joint damping over joint stiffness", least=0)
    joint_friction: float | None = number(
        None, "N m", "dry friction of each hinge (creeps under a steady load); omitted: none", above=0
    )
    friction_moment: float | None = number(
        None, "N m", "bending moment at which friction in the backbone slides; omitted: none", above=0
    )
    friction_stiffness: float | None = number(
        None, "N m^2", "bending stiffness that this friction adds while it sticks; omitted: none", above=0
    )
    section_radius: float | None = number(
        None, "m", "radius of the round section that the mass fills (rotary inertia); omitted: the disks'", above=0
    )
    contact_radius: float | None = number(
        None, "m", "radius of what touches; omitted: of its disks, or of its muscles at their fattest where these reach"
        " beyond", above=0
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_numbers(self)
        try:
            links = 0 if isinstance(self.links, bool) else operator.index(self.links)
        except TypeError:
            links = 0
        if not 2 <= links <= MAX_LINKS:
            raise InputError("links", self.links, f"a whole number from 2 to {MAX_LINKS}")
        object.__setattr__(self, "links", links)
        for name, other in (("friction_moment", "friction_stiffness"), ("friction_stiffness", "friction_moment")):
            if getattr(self, name) is not None and getattr(self, other) is None:
                raise InputError(name, getattr(self, name), f"{other} beside it: friction needs both")

    @property
    def link_pitch(self) -> float:
        """Distance h between neighbouring joints [m]."""
        return self.length / self.links

    @property
    def joint_stiffness(self) -> float:
        """Stiffness of each joint against bending [N m/rad]."""
        return self.bending_stiffness / self.link_pitch

    @property
    def sticking_stiffness(self) -> float:
        """Stiffness that friction adds to each joint while it sticks [N m/rad]."""
        return (self.friction_stiffness or 0.0) / self.link_pitch

    @property
    def guide_height(self) -> float:
        """Height [m] of the guides of straight spans above the middle of their link, see `GUIDE`."""
        return GUIDE * self.link_pitch

"""Where the muscles of one section run."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, field
from typing import Literal, get_args

from contarm_sim.errors import InputError
from contarm_sim.model.parameters import check_numbers, number

Path = Literal["parallel", "spans"]
PATHS: tuple[Path, ...] = get_args(Path)

Start = Literal["section", "base"]
STARTS: tuple[Start, ...] = get_args(Start)

MAX_MUSCLES = 12
"""Most muscles of a section."""


@dataclass(frozen=True, kw_only=True)
class Routing:
    """The muscles of one section, evenly spaced on a circle about the backbone. They end at the end of the section.

    Attributes:
        radius: of the circle [m].
        count: muscles of the section; 0 for a section without muscles of its own.
        offset: angle of the first muscle about +Z from +X [rad].
        path: `parallel`: sheathed along the backbone, everywhere at the radius from it, as the paper draws them;
            lengths are those of the arc. `spans`: straight from disk to disk, one disk a link, as cables through few
            disks run.
        start: `section`: the muscles begin where their section begins. `base`: they begin at the base of the arm and
            pass through the sections before theirs.

    Raises:
        InputError: a parameter that is not in its stated interval.
    """

    radius: float = number(0.018, "m", "radius r of the muscles' attachment circle (paper)", above=0)
    count: int = 3
    offset: float = number(0.0, "rad", "angle of the first muscle about +Z from +X")
    path: Path = field(
        default="parallel",
        metadata={
            "unit": "-",
            "help": "where muscles run: parallel to the backbone, or in straight spans from disk to disk",
            "choices": PATHS,
        },
    )
    start: Start = "section"

    def __post_init__(self) -> None:
        try:
            check_numbers(self, "muscle_")
        except InputError as error:  # TOML says muscle_radius, and offset in [muscle]
            raise InputError(error.name.replace("_offset", ".offset"), error.given, error.allowed) from None
        try:
            count = -1 if isinstance(self.count, bool) else operator.index(self.count)
        except TypeError:
            count = -1
        if not 0 <= count <= MAX_MUSCLES:
            raise InputError("muscle.count", self.count, f"a whole number from 0 to {MAX_MUSCLES}")
        object.__setattr__(self, "count", count)
        for name, allowed in (("path", PATHS), ("start", STARTS)):
            if getattr(self, name) not in allowed:
                raise InputError(f"muscle.{name}", repr(getattr(self, name)), ", ".join(allowed))

    @property
    def angles(self) -> tuple[float, ...]:
        """Angles psi_i [rad] of the muscles about +Z from +X."""
        return tuple(self.offset + 2 * math.pi * index / self.count for index in range(self.count))

    @property
    def points(self) -> tuple[tuple[float, float], ...]:
        """Where the muscles cross a plane across the backbone: x and y [m] of each."""
        return tuple((self.radius * math.cos(angle), self.radius * math.sin(angle)) for angle in self.angles)

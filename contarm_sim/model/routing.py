"""Where the muscles of one section run."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, field
from typing import Literal, get_args

from contarm_sim.brevity import Told
from contarm_sim.errors import InputError
from contarm_sim.model.parameters import LARGEST, as_numbers, check_numbers, number

Path = Literal["parallel", "spans"]
PATHS: tuple[Path, ...] = get_args(Path)

Start = Literal["section", "base"]
STARTS: tuple[Start, ...] = get_args(Start)

MAX_MUSCLES = 12
"""Most muscles of a section."""

NEAREST = 1e-6
"""Least distance of two muscles of an arm [their radii]: nearer ones are the same muscle twice."""


def coinciding(points: tuple[tuple[float, float], ...], *others: tuple[float, float]) -> tuple[int, int] | None:
    """Return the numbers of the first two places [m] that are the same, or None.

    Args:
        points: places across the backbone, compared with one another, or with `others` if there are any.
    """
    for first, point in enumerate(points):
        for second, other in enumerate(others or points[:first]):
            if math.dist(point, other) <= NEAREST * math.hypot(*point):
                return (first, second) if others else (second, first)
    return None


@dataclass(frozen=True, kw_only=True, repr=False)
class Routing(Told):
    """The muscles of one section, on a circle about the backbone. They end at the end of the section.

    Attributes:
        radius: of the circle [m].
        count: muscles of the section, evenly spaced; 0 for a section without muscles of its own.
        offset: angle of the first muscle about +Z from +X [rad].
        at: the muscles' own angles about +Z [rad], counted from `offset`, in place of even spacing; None: even.
        path: `parallel`: sheathed along the backbone, everywhere at the radius from it, as the paper draws them;
            lengths are those of the arc. `spans`: straight from disk to disk, one disk a link, as cables through few
            disks run.
        start: `section`: the muscles begin where their section begins. `base`: they begin at the base of the arm and
            pass through the sections before theirs.

    Raises:
        InputError: a parameter that is not in its stated interval, or muscles that coincide.
    """

    radius: float = number(0.018, "m", "radius r of the muscles' attachment circle (paper)", above=0)
    count: int = 3
    offset: float = number(0.0, "rad", "angle of the first muscle about +Z from +X")
    at: tuple[float, ...] | None = None
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
        if self.at is not None:
            self._place()
        for name, allowed in (("path", PATHS), ("start", STARTS)):
            if getattr(self, name) not in allowed:
                raise InputError(f"muscle.{name}", repr(getattr(self, name)), ", ".join(allowed))

    def _place(self) -> None:
        """Check the given angles, and count them."""
        given = as_numbers(self.at)
        if given is None or not 1 <= len(given) <= MAX_MUSCLES or not all(abs(x) <= LARGEST for x in given):
            shown = repr(self.at) if isinstance(self.at, str) else self.at
            raise InputError("muscle.angles", shown, f"1 to {MAX_MUSCLES} finite angles [rad]")
        if self.count not in (len(given), type(self).count):
            raise InputError("muscle.count", self.count, f"{len(given)}, as many as muscle.angles, or one of the two")
        object.__setattr__(self, "at", given)
        object.__setattr__(self, "count", len(given))
        if near := coinciding(self.points):
            allowed = "muscles at places of their own: these coincide"
            raise InputError("muscle.angles", f"{given[near[0]]:g} and {given[near[1]]:g}", allowed)

    @property
    def angles(self) -> tuple[float, ...]:
        """Angles psi_i [rad] of the muscles about +Z from +X."""
        if self.at is not None:
            return tuple(self.offset + angle for angle in self.at)
        return tuple(self.offset + 2 * math.pi * index / self.count for index in range(self.count))

    @property
    def shares(self) -> tuple[float, ...]:
        """Tensions of the muscles at which they bend a straight section in no direction; the least is 1.

        What is nearest to equal ones: (1, ..., 1) for evenly spaced muscles, and where no pulling muscles balance.
        """
        even = (1.0,) * self.count
        if self.at is None or self.count < 3:
            return even
        u = [(math.cos(angle), math.sin(angle)) for angle in self.angles]
        xx, yy, xy = (sum(one[i] * one[j] for one in u) for i, j in ((0, 0), (1, 1), (0, 1)))
        x, y = (sum(one[i] for one in u) for i in (0, 1))
        size = xx * yy - xy * xy
        if size <= 0:
            return even
        ax, ay = (yy * x - xy * y) / size, (xx * y - xy * x) / size
        free = [1 - ax * one[0] - ay * one[1] for one in u]
        return tuple(share / min(free) for share in free) if min(free) > 0 else even

    @property
    def points(self) -> tuple[tuple[float, float], ...]:
        """Where the muscles cross a plane across the backbone: x and y [m] of each."""
        return tuple((self.radius * math.cos(angle), self.radius * math.sin(angle)) for angle in self.angles)

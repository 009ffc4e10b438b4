"""A host: a user's own MJCF that the arm is attached to, and where."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from contarm_sim.brevity import Told
from contarm_sim.errors import InputError, did_you_mean
from contarm_sim.inputs import as_path
from contarm_sim.model.host_file import HostFile, Place, host_file, rotated, turned_back
from contarm_sim.model.objects import ITSELF
from contarm_sim.model.parameters import Quaternion, Vector, check_vector

STRAIGHT_ON: Quaternion = (1.0, 0.0, 0.0, 0.0)

MOST_PARTNERS = 16
"""Most bodies of a host that contacts tell apart; of more, all that is touched is one."""

WORLD = "world"
"""What MuJoCo calls the body that does not move, and what a host of many bodies is called in contacts."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Host(Told):
    """A user's own MJCF that the arm is attached to: at a site, or at a pose in a body.

        Host(file="cell.xml", site="mount")
        Host(file="cell.xml", body="cart", position=(0, 0, -0.05), orientation=(0, 1, 0, 0))

    The base plate's centre goes there, +Z along the straight arm. The base is welded to that body and moves with it.
    The file is read at construction; what it then says of gravity becomes the arm's.

    Raises:
        InputError: a file that is not there or that MuJoCo does not take, a site or body that it lacks, a pose beside a
            site, or options under which the arm cannot be simulated.
    """

    file: str
    site: str | None = field(default=None, metadata={"unit": "-", "help": "where the base goes"})
    body: str | None = field(default=None, metadata={"unit": "-", "help": "that a pose is in; omitted: the world"})
    position: Vector = field(default=(0.0, 0.0, 0.0), metadata={"unit": "m", "help": "of the base in that body"})
    orientation: Quaternion = field(default=STRAIGHT_ON, metadata={"unit": "-", "help": "of the base, w x y z"})

    def __post_init__(self) -> None:
        path = as_path("world", self.file, "an MJCF file, .xml")
        if not path.is_file():
            raise InputError("world", f"{str(self.file)!r}, which is not there", "an MJCF file, .xml")
        object.__setattr__(self, "file", str(path.resolve()))
        check_vector(self, "position", 3)
        check_vector(self, "orientation", 4)
        norm = math.hypot(*self.orientation)
        if norm == 0:
            raise InputError("orientation", self.orientation, "a quaternion w x y z, not zero", "world")
        object.__setattr__(self, "orientation", tuple(x / norm for x in self.orientation))
        self._check_mount(self.read)
        if ITSELF in self.partners:
            raise InputError(
                "world", f"{path.name!r} with a body {ITSELF!r}", "another name: the arm's contact with itself has it"
            )

    def _check_mount(self, read: HostFile) -> None:
        if self.site is not None:
            for name, usual in (("body", None), ("position", (0.0, 0.0, 0.0)), ("orientation", STRAIGHT_ON)):
                if getattr(self, name) != usual:
                    raise InputError(name, getattr(self, name), "omitted beside a site, which says where", "world")
        for name, known in (("site", read.sites), ("body", read.bodies)):
            given: Any = getattr(self, name)
            if given is not None and given not in known:
                every = ", ".join(known) or "none; a pose is given by body, position and orientation"
                allowed = f"{did_you_mean(given, known)}those of {Path(self.file).name}: {every}"
                raise InputError(name, repr(given), allowed, "world")

    @property
    def read(self) -> HostFile:
        """What its file says; read once as long as it stays as it is."""
        return host_file(self.file)

    @property
    def mount(self) -> str:
        """The body that the base is welded to."""
        return self.read.sites[self.site].body if self.site is not None else self.body or WORLD

    @property
    def base(self) -> Place:
        """Where the base is at the start."""
        if self.site is not None:
            return self.read.sites[self.site]
        within = self.read.bodies[self.mount]
        position = rotated(self.position, within.quaternion)
        return Place(
            self.mount,
            tuple(a + b for a, b in zip(within.position, position, strict=True)),  # type: ignore[arg-type]
            _product(within.quaternion, self.orientation),
            within.moves,
        )

    @property
    def moves(self) -> bool:
        """Whether the base may move."""
        return self.base.moves

    @property
    def gravity(self) -> Vector:
        """Gravity in the base frame at the start [m/s^2]."""
        x, y, z = turned_back(self.read.gravity, self.base.quaternion)
        return round(x, 12) + 0.0, round(y, 12) + 0.0, round(z, 12) + 0.0

    @property
    def partners(self) -> tuple[str, ...]:
        """The bodies that the arm can touch; of too many the world, which stands for all."""
        found = self.read.touched
        return found if len(found) <= MOST_PARTNERS else (WORLD,)

    @property
    def lumped(self) -> bool:
        """Whether it has too many bodies for contacts to tell apart."""
        return len(self.read.touched) > MOST_PARTNERS


def _product(one: Quaternion, other: Quaternion) -> Quaternion:
    a, b, c, d = one
    w, x, y, z = other
    return (
        a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w,
    )  # fmt: skip

"""What an arm stands in: gravity, which way its base is turned, what its tip carries, and what it can touch."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace

from contarm_sim.brevity import Told
from contarm_sim.errors import InputError, expect
from contarm_sim.model.host import Host
from contarm_sim.model.objects import ITSELF, Object, check_objects
from contarm_sim.model.parameters import Quaternion, Vector, check_numbers, check_vector, number

_AGREE = 1e-6
"""How far gravity and the base's turn may be from those of a host, as shares."""


@dataclass(frozen=True, kw_only=True, repr=False)
class World(Told):
    """Gravity, base, payload, objects and host. SI units, vectors in the base frame, checked at construction.

    Attributes:
        objects: what the arm can touch.
        self_contact: whether the arm's links touch one another.
        host: a user's own MJCF that the arm is attached to. It says gravity and how the base is turned, both at the
            start: given beside it, they must agree.

    Raises:
        InputError: not finite numbers, a quaternion of zeros, objects that do not go together, or gravity or a base
            that are not those of the host.
    """

    gravity: Vector = field(
        default=(0.0, 0.0, 0.0),
        metadata={"unit": "m/s^2", "help": "gravity in the base frame; 0 0 9.81 hangs the arm, 0 0 -9.81 stands it up"},
    )
    base_orientation: Quaternion | None = field(
        default=None,
        metadata={
            "unit": "-",
            "help": "quaternion w x y z of the drawn base; omitted: gravity points down the picture",
        },
    )
    payload: float = number(0.0, "kg", "point mass at the tip", least=0)
    objects: tuple[Object, ...] = ()
    self_contact: bool = False
    host: Host | None = None

    def __post_init__(self) -> None:
        check_numbers(self)
        object.__setattr__(self, "objects", check_objects(self.objects))
        expect("self_contact", self.self_contact, bool)
        check_vector(self, "gravity", 3)
        if self.base_orientation is not None:
            check_vector(self, "base_orientation", 4)
            norm = math.hypot(*self.base_orientation)
            if norm == 0:
                raise InputError("base_orientation", self.base_orientation, "a quaternion w x y z, not zero")
            object.__setattr__(self, "base_orientation", tuple(x / norm for x in self.base_orientation))
        if self.host is not None:
            expect("host", self.host, Host)
            self._agree(self.host)

    def _agree(self, host: Host) -> None:
        """Take gravity and the base's turn from a host.

        Raises:
            InputError: others are given.
        """
        said = host.gravity
        if any(self.gravity) and math.dist(self.gravity, said) > _AGREE * max(1.0, math.hypot(*said)):
            allowed = f"omitted: the world has {' '.join(f'{x:.6g}' for x in said)} in the base frame"
            raise InputError("gravity", " ".join(f"{x:.6g}" for x in self.gravity), allowed)
        turn, given = host.base.quaternion, self.base_orientation
        if given is not None and abs(sum(a * b for a, b in zip(turn, given, strict=True))) < 1 - _AGREE:
            raise InputError("base_orientation", given, "omitted: the world says how the base is turned")
        object.__setattr__(self, "gravity", said)
        object.__setattr__(self, "base_orientation", turn)

    def hosted(self, host: Host) -> World:
        """Return the same world in a host, whose gravity and base take the place of its own."""
        return replace(self, host=host, gravity=(0.0, 0.0, 0.0), base_orientation=None)

    @property
    def touchable(self) -> bool:
        """Whether there is anything that the arm can touch."""
        return bool(self.objects) or self.self_contact or self.host is not None

    @property
    def partners(self) -> tuple[str, ...]:
        """What the arm can touch: objects, `ITSELF`, and bodies of the host; of too many the world, for all of it."""
        if self.host is not None and self.host.lumped:
            return self.host.partners
        own = (ITSELF,) if self.self_contact else ()
        return (*(each.name for each in self.objects), *own, *(self.host.partners if self.host is not None else ()))

    @property
    def movable(self) -> list[str]:
        """Names of the objects that move."""
        return [each.name for each in self.objects if each.free]

    @property
    def alone(self) -> World:
        """The same world without anything that the arm can touch; gravity stays that of the start."""
        return replace(self, objects=(), self_contact=False, host=None) if self.touchable else self

    @property
    def gravity_strength(self) -> float:
        """Size of gravity [m/s^2]."""
        return math.hypot(*self.gravity)

    @property
    def up(self) -> tuple[float, float, float]:
        """Direction of the base frame that is up where the arm is drawn, of length 1.

        As `base_orientation` says, else against gravity, else along the straight arm.
        """
        if self.base_orientation is not None:
            w, x, y, z = self.base_orientation
            return 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        if not any(self.gravity):
            return 0.0, 0.0, 1.0
        x, y, z = (-part / self.gravity_strength for part in self.gravity)
        return x, y, z

    def moment(self, mass: float, length: float) -> float:
        """Return the moment on a uniform bend [N m/rad] that counts for servos: a quarter of weight times length.

        Args:
            mass: spread evenly [kg]; the payload is at its end.
            length: of what hangs or stands [m].
        """
        return 0.25 * ((0.5 * mass + self.payload) * self.gravity_strength * length)

    def bend_inertia(self, mass: float, length: float) -> float:
        """Return the inertia of a uniform bend [kg m^2], whose tip moves by half a length a radian."""
        return (mass / 20 + self.payload / 4) * length**2


WORLD_PARAMETERS = {item.name: item for item in fields(World) if "unit" in item.metadata}
"""Declarations of the parameters of a world that are numbers, by name."""

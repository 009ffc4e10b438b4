"""What an arm can touch: fixed and free bodies of simple shapes, or of a mesh, in the base frame."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args

from contarm_sim.brevity import Told
from contarm_sim.errors import InputError
from contarm_sim.model.parameters import Quaternion, Vector, check_numbers, check_vector, number

Shape = Literal["box", "sphere", "capsule", "cylinder", "plane", "mesh"]
SHAPES: tuple[Shape, ...] = get_args(Shape)

SIZED_BY: dict[str, tuple[str, ...]] = {
    "box": ("size",), "sphere": ("radius",), "capsule": ("radius", "length"), "cylinder": ("radius", "length"),
    "plane": (), "mesh": ("file",),
}  # fmt: skip
"""The fields that say how large an object of each shape is; it has these and no others."""

MEANING = {
    "size": "its three edges [m]",
    "radius": "its radius [m]",
    "length": "its length [m], of a capsule without its round ends",
    "file": "a mesh, binary .stl or .obj",
}

ITSELF = "itself"
"""What an arm is called that touches itself."""

MESHES = (".stl", ".obj")

MAX_OBJECTS = 32
"""Most objects of a world."""

LEAST_MASS = 1e-5
"""Lightest free object [kg]: a lighter one is lost beside the arm's links."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Object(Told):
    """A rigid body that an arm can touch. SI units, base frame, checked at construction.

        Object(name="post", shape="cylinder", radius=0.01, length=0.4, position=(0.1, 0, 0.2), axis=(0, 1, 0))
        Object(name="ball", shape="sphere", radius=0.02, mass=0.05, position=(0.1, 0, 0.3))

    Raises:
        InputError: an unknown shape, one without its size or with that of another, numbers outside of their intervals,
            or a mesh that is not there; says of which object.
    """

    name: str
    shape: Shape = field(metadata={"unit": "-", "help": f"one of {', '.join(SHAPES)}"})
    position: Vector = field(
        default=(0.0, 0.0, 0.0),
        metadata={
            "unit": "m",
            "help": "of its middle; planes run through it, meshes have their files' origin there; omitted: the base",
        },
    )
    axis: Vector | None = field(
        default=None,
        metadata={
            "unit": "-",
            "help": "direction of its own Z: along capsules and cylinders, out of planes; omitted: +Z, or as"
            " orientation says",
        },
    )
    orientation: Quaternion | None = field(
        default=None, metadata={"unit": "-", "help": "quaternion w x y z, in place of axis"}
    )
    size: Vector | None = field(default=None, metadata={"unit": "m", "help": "the three edges of a box"})
    radius: float | None = number(None, "m", "of a sphere, capsule or cylinder", above=0)
    length: float | None = number(None, "m", "of a cylinder, or of a capsule without its round ends", above=0)
    file: str | None = field(
        default=None, metadata={"unit": "-", "help": "of a mesh, binary .stl or .obj; it touches as its convex hull"}
    )
    scale: float = number(1.0, "-", "what the numbers of a mesh's file are times one metre: 0.001 for mm", above=0)
    mass: float | None = number(None, "kg", "of a free object; omitted: fixed to the base frame", least=LEAST_MASS)
    friction: float = number(0.8, "-", "coefficient of sliding friction of whatever touches it", least=0)
    colour: Vector = field(
        default=(0.80, 0.52, 0.25), metadata={"unit": "-", "help": "red, green and blue, 0 to 1 each"}
    )

    def __post_init__(self) -> None:
        try:
            self._check()
        except InputError as error:
            raise error.located(said_of_object(self.name)) from None

    def _check(self) -> None:
        if not isinstance(self.name, str) or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,31}", self.name):
            allowed = "a letter, then letters, digits, _ or -, at most 32 in all"
            raise InputError("name", repr(self.name), allowed)
        if self.name == ITSELF:
            raise InputError("name", repr(self.name), "another: self-contact is called so")
        if not isinstance(self.shape, str) or self.shape not in SHAPES:
            raise InputError("shape", repr(self.shape), ", ".join(SHAPES))
        check_numbers(self)
        check_vector(self, "position", 3)
        check_vector(self, "colour", 3)
        if not all(0 <= part <= 1 for part in self.colour):
            raise InputError("colour", self.colour, "red, green and blue, 0 to 1 each")
        self._check_size()
        self._check_turn()
        if self.shape == "plane" and self.mass is not None:
            raise InputError("mass", self.mass, "omitted: a plane has no end, and stays where it is")

    def _check_size(self) -> None:
        wanted = SIZED_BY[self.shape]
        for name, meaning in MEANING.items():
            given = getattr(self, name)
            if name in wanted and given is None:
                raise InputError(name, "missing", f"for a {self.shape}, {meaning}")
            if name not in wanted and given is not None:
                has = " and ".join(wanted) if wanted else "no size: it has no end"
                raise InputError(name, given, f"omitted: a {self.shape} has {has}")
        if self.size is not None:
            check_vector(self, "size", 3)
            if min(self.size) <= 0:
                raise InputError("size", self.size, "three edges, greater than 0 m")
        if self.shape != "mesh" and self.scale != 1.0:
            raise InputError("scale", self.scale, f"omitted: a {self.shape} is no mesh")
        if self.file is not None:
            self._check_mesh(self.file)

    def _check_mesh(self, given: Any) -> None:
        if not isinstance(given, (str, Path)) or Path(given).suffix.lower() not in MESHES:
            raise InputError("file", repr(str(given)), f"a mesh, {' or '.join(MESHES)}")
        if not Path(given).is_file():
            raise InputError("file", f"{str(given)!r}, which is not there", f"a mesh, {' or '.join(MESHES)}")
        object.__setattr__(self, "file", str(given))

    def _check_turn(self) -> None:
        if self.axis is not None and self.orientation is not None:
            raise InputError("axis", self.axis, "omitted where orientation is given")
        for name, size in (("axis", 3), ("orientation", 4)):
            if getattr(self, name) is not None:
                check_vector(self, name, size)
                norm = math.hypot(*getattr(self, name))
                if norm == 0:
                    raise InputError(name, getattr(self, name), "not zero")
                object.__setattr__(self, name, tuple(x / norm for x in getattr(self, name)))

    @property
    def free(self) -> bool:
        """Whether it moves."""
        return self.mass is not None

    @property
    def beside(self) -> str | None:
        """The name of its mesh's file where that lies beside the arm's, or None."""
        return None if self.file is None else f"{self.name}{Path(self.file).suffix.lower()}"

    @property
    def quaternion(self) -> Quaternion:
        """How it is turned in the base frame, w x y z: of an axis, the smallest turn of Z to it."""
        if self.orientation is not None:
            return self.orientation
        if self.axis is None:
            return 1.0, 0.0, 0.0, 0.0
        x, y, z = self.axis
        if z < -1 + 1e-12:
            return 0.0, 1.0, 0.0, 0.0
        norm = math.sqrt(2 * (1 + z))
        return norm / 2, -y / norm, x / norm, 0.0


def said_of_object(name: Any) -> str:
    """Return what a message about an object begins with."""
    return f"object {name!r}" if isinstance(name, str) else "object"


def check_objects(objects: Any) -> tuple[Object, ...]:
    """Return the objects of a world as a tuple.

    Raises:
        InputError: no tuple of objects, too many, or two of one name.
    """
    if not isinstance(objects, (tuple, list)) or not all(isinstance(each, Object) for each in objects):
        raise InputError("objects", objects, "a tuple of Object")
    if len(objects) > MAX_OBJECTS:
        raise InputError("objects", f"{len(objects)} of them", f"at most {MAX_OBJECTS}")
    names = [each.name for each in objects]
    for name in names:
        if names.count(name) > 1:
            raise InputError("name", repr(name), "another name for each object", said_of_object(name))
    return tuple(objects)

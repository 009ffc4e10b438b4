"""The arm: one set of parameters that the analytic and the simulated arm are both derived from.

An arm is a chain of sections; each has muscles (a routing) that pull by a law; the whole stands in a world. `Arm()` is
the paper's arm, of one section. What the paper does not publish is an assumption; each one's reason stands in its
field's help and in the README's table. Imports nothing heavy: the command line is built from it.
"""

from __future__ import annotations

import math
from dataclasses import InitVar, dataclass, replace
from functools import cached_property
from itertools import combinations, product
from typing import TYPE_CHECKING, Any

from contarm_sim.display import Shown
from contarm_sim.errors import InputError
from contarm_sim.model.flat import FlatArm
from contarm_sim.model.host import Host
from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.objects import Object
from contarm_sim.model.parameters import Quaternion, Vector
from contarm_sim.model.routing import Path, Routing, coinciding
from contarm_sim.model.said import said
from contarm_sim.model.section import MAX_LINKS, MAX_SECTIONS, Section
from contarm_sim.model.world import World

LEAST_INERTIA = 1e-15
"""Smallest moment of inertia that the engine accepts [kg m^2]."""

LEAST_SHARE = 1e-14
"""Smallest moment of inertia of half a link over that of all that it carries: less is lost in the engine's rounding."""


class _Omitted:
    """Says that an argument was not given: None is a value of some."""

    def __repr__(self) -> str:
        return "..."


OMITTED: Any = _Omitted()


@dataclass(frozen=True, init=False, repr=False)
class Arm(FlatArm, Shown):
    """A continuum arm of inextensible sections. SI units, vectors in the base frame, checked at construction.

        Arm(length=0.5, muscle=McKibben(wall=0.003), gravity=(0, 0, 9.81))     one section, all else as in the paper
        Arm(sections=(Section(length=0.2), Section(length=0.17)))              two, each with three muscles of its own
        dataclasses.replace(arm, links=12)                                     the same arm with fewer links

    Attributes:
        sections: from the base to the tip.
        routings: where the muscles run, one routing for each section; default the paper's for every section.
        laws: how the muscles pull, one law for each section; default the paper's for every section.
        world: gravity, base, payload, what the arm can touch, and a host.

    The other arguments change the only section, its muscles, or the world: they are the fields of `Section`, `World`,
    and of `Routing` (`muscle_radius`, `path`); `muscle` is the law. Properties of the same names read them, see
    `FlatArm`.

    Raises:
        InputError: a parameter is not a finite number in its stated interval, or an argument that says nothing of one
            section alone is given for an arm of several.
    """

    sections: tuple[Section, ...]
    routings: tuple[Routing, ...]
    laws: tuple[MuscleLaw, ...]
    world: World
    if TYPE_CHECKING:  # what `dataclasses.replace` takes beside the fields
        length: InitVar[float] = OMITTED
        links: InitVar[int] = OMITTED
        mass: InitVar[float] = OMITTED
        bending_stiffness: InitVar[float] = OMITTED
        torsional_stiffness: InitVar[float | None] = OMITTED
        damping_time: InitVar[float] = OMITTED
        joint_friction: InitVar[float | None] = OMITTED
        friction_moment: InitVar[float | None] = OMITTED
        friction_stiffness: InitVar[float | None] = OMITTED
        section_radius: InitVar[float | None] = OMITTED
        contact_radius: InitVar[float | None] = OMITTED
        muscle_radius: InitVar[float] = OMITTED
        path: InitVar[Path] = OMITTED
        muscle: InitVar[MuscleLaw] = OMITTED
        gravity: InitVar[Vector] = OMITTED
        base_orientation: InitVar[Quaternion | None] = OMITTED
        payload: InitVar[float] = OMITTED
        objects: InitVar[tuple[Object, ...]] = OMITTED
        self_contact: InitVar[bool] = OMITTED
        host: InitVar[Host | None] = OMITTED

    def __init__(
        self,
        *,
        sections: tuple[Section, ...] = OMITTED,
        routings: tuple[Routing, ...] = OMITTED,
        laws: tuple[MuscleLaw, ...] = OMITTED,
        world: World = OMITTED,
        length: float = OMITTED,
        links: int = OMITTED,
        mass: float = OMITTED,
        bending_stiffness: float = OMITTED,
        torsional_stiffness: float | None = OMITTED,
        damping_time: float = OMITTED,
        joint_friction: float | None = OMITTED,
        friction_moment: float | None = OMITTED,
        friction_stiffness: float | None = OMITTED,
        section_radius: float | None = OMITTED,
        contact_radius: float | None = OMITTED,
        muscle_radius: float = OMITTED,
        path: Path = OMITTED,
        muscle: MuscleLaw = OMITTED,
        gravity: Vector = OMITTED,
        base_orientation: Quaternion | None = OMITTED,
        payload: float = OMITTED,
        objects: tuple[Object, ...] = OMITTED,
        self_contact: bool = OMITTED,
        host: Host | None = OMITTED,
    ) -> None:
        of_section = _given(
            length=length, links=links, mass=mass, bending_stiffness=bending_stiffness,
            torsional_stiffness=torsional_stiffness, damping_time=damping_time, joint_friction=joint_friction,
            friction_moment=friction_moment, friction_stiffness=friction_stiffness, section_radius=section_radius,
            contact_radius=contact_radius,
        )  # fmt: skip
        of_routing = _given(radius=muscle_radius, path=path)
        of_world = _given(
            gravity=gravity, base_orientation=base_orientation, payload=payload, objects=objects,
            self_contact=self_contact, host=host,
        )  # fmt: skip
        parts = _tuple("sections", sections, Section, 1 if sections is OMITTED else None)
        lines = _tuple("routings", routings, Routing, len(parts))
        pulls = _tuple("laws", laws, MuscleLaw, len(parts))
        flat = {**of_section, **_given(muscle_radius=muscle_radius, path=path, muscle=muscle)}
        if len(parts) > 1 and flat:
            name, value = next(iter(flat.items()))
            raise InputError(name, value, f"an arm of one section; this one has {len(parts)}: change its sections")
        if muscle is not OMITTED:
            pulls = _tuple("muscle", (muscle,), MuscleLaw, 1)
        if world is not OMITTED and not isinstance(world, World):
            raise InputError("world", world, "a World")
        own = World() if world is OMITTED else world
        object.__setattr__(self, "sections", (replace(parts[0], **of_section), *parts[1:]) if of_section else parts)
        object.__setattr__(self, "routings", (replace(lines[0], **of_routing), *lines[1:]) if of_routing else lines)
        object.__setattr__(self, "laws", pulls)
        object.__setattr__(self, "world", replace(own, **of_world) if of_world else own)
        self._check()

    def __repr__(self) -> str:
        return said(self)

    def _check(self) -> None:
        if len(self.sections) > MAX_SECTIONS:
            raise InputError("sections", f"{len(self.sections)} of them", f"at most {MAX_SECTIONS}")
        if sum(section.links for section in self.sections) > MAX_LINKS:
            raise InputError("links", self.links, f"at most {MAX_LINKS} in all")
        for group, number in product(self.groups, range(len(self.sections))):
            length = self.sections[number].length
            if group.crosses(number) and group.routing.radius * math.pi >= length:
                through = "" if group.section == number else f" for muscles that pass through section {number + 1}"
                allowed = f"below length/pi, {length / math.pi:.4g} m{through}"
                raise InputError("muscle_radius", group.routing.radius, allowed, self._said_of(group.section))
        self._check_places()
        for number in range(len(self.sections)):
            self._check_inertia(number)

    def _check_inertia(self, number: int) -> None:
        """Refuse a section whose links the engine cannot turn: too light for it, or beside what they carry.

        Raises:
            InputError: the mass that it takes.
        """
        section = self.sections[number]
        radius = section.section_radius or self.disk_radii[number]
        thin = radius**2 / 4  # of half a link about its axis
        thick = radius**2 / 8 + section.link_pitch**2 / 96  # and about its diameter
        beyond = self.sections[number + 1 :]
        carried = self.payload + sum(part.mass for part in beyond)
        reach = sum(part.length for part in (section, *beyond))
        turning = thick if section.torsional_stiffness is None else min(thin, thick)
        light = LEAST_INERTIA * section.links / min(thin, thick)
        beside = LEAST_SHARE * carried * reach**2 * section.links / turning
        if section.mass <= max(light, beside):
            what = (
                "links that the engine can turn"
                if light >= beside
                else "links that are not lost beside what they carry"
            )
            allowed = f"more than {max(light, beside):.3g} kg, for {what}"
            raise InputError("mass", section.mass, allowed, self._said_of(number))

    def _check_places(self) -> None:
        """Refuse muscles of two sections that run at the same place through a section.

        Raises:
            InputError: names the two.
        """
        for group, other in combinations(self.groups, 2):
            shared = other.crosses(group.section) and coinciding(group.routing.points, *other.routing.points)
            if shared:
                name = f"muscle {shared[1] + 1} of section {other.section + 1}"
                given = f"where muscle {shared[0] + 1} of section {group.section + 1} is: muscles that coincide"
                raise InputError(name, given, "another muscle_offset, muscle_angles or muscle_radius of one of the two")

    def _said_of(self, number: int) -> str | None:
        """Return what a message begins with that speaks of a section, numbered from 0."""
        return f"section {number + 1}" if len(self.sections) > 1 else None

    def in_world(self, world: World) -> Arm:
        """Return the same arm in another world."""
        return replace(self, world=world)

    @property
    def unloaded(self) -> Arm:
        """The same arm without gravity and payload, and without a host, which says gravity."""
        return self.in_world(replace(self.world, host=None, gravity=(0.0, 0.0, 0.0), payload=0.0))

    @property
    def alone(self) -> Arm:
        """The same arm without anything that it can touch."""
        return self.in_world(self.world.alone) if self.world.touchable else self

    @property
    def without_memory(self) -> Arm:
        """The same arm without friction in its backbone and along its tendons: poses without what came before."""
        backbone = any(section.friction_moment is not None for section in self.sections)
        along = [getattr(law, "friction_coefficient", None) is not None for law in self.laws]
        if not (backbone or any(along)):
            return self
        parts = (replace(section, friction_moment=None, friction_stiffness=None) for section in self.sections)
        laws: Any = (
            replace(law, friction_coefficient=None) if rubs else law  # type: ignore[call-arg]  # it has the field
            for law, rubs in zip(self.laws, along, strict=True)
        )
        return replace(self, sections=tuple(parts), laws=tuple(laws))

    def refuse_memory(self, what: str, backbone: bool = True) -> None:
        """Refuse friction in the backbone and along tendons, where it would be left out without a word.

        Args:
            what: would leave it out.
            backbone: whether in the backbone as well.

        Raises:
            InputError: says so.
        """
        for number, section in enumerate(self.sections):
            if backbone and section.friction_moment is not None:
                allowed = f"omitted: {what} without friction in the backbone; fits and replays of recordings know it"
                raise InputError("friction_moment", section.friction_moment, allowed, self._said_of(number))
        for number, law in enumerate(self.laws):
            given = getattr(law, "friction_coefficient", None)
            if given is not None:
                allowed = f"omitted: {what} without friction along tendons; slow poses of recordings know it"
                raise InputError("muscle.friction_coefficient", given, allowed, self._said_of(number))

    def refuse_objects(self, what: str) -> None:
        """Refuse objects, self-contact and a host, where they would be left out without a word.

        Args:
            what: would leave them out.

        Raises:
            InputError: says so.
        """
        if self.world.touchable:
            names = ", ".join(each.name for each in self.world.objects)
            name, given, flags = "objects", names, "--objects and [[object]]"
            if not names:
                name, given, flags = "self_contact", "on", "--self-contact and self_contact"
            if self.world.host is not None:
                name, given, flags = "world", repr(self.world.host.file), "--world and [world]"
            raise InputError(name, given, f"none: {what} without contact; leave out {flags} (in Python, arm.alone)")

    @cached_property
    def groups(self) -> tuple[MuscleGroup, ...]:
        """The muscles, one group for each section that has any, from the base to the tip."""
        made = (self._group(number) for number, routing in enumerate(self.routings) if routing.count)
        return tuple(made)

    def _group(self, number: int) -> MuscleGroup:
        routing, section = self.routings[number], self.sections[number]
        first = number if routing.start == "section" else 0
        beyond, world = self.sections[number:], self.world
        length, mass = sum(part.length for part in beyond), sum(part.mass for part in beyond)
        return MuscleGroup(
            section=number,
            first=first,
            routing=routing,
            law=self.laws[number],
            length=sum(part.length for part in self.sections[first : number + 1]),
            bending_resistance=max(section.bending_stiffness / section.length, world.moment(mass, length)),
            bend_inertia=world.bend_inertia(mass, length),
        )

    @cached_property
    def disk_radii(self) -> tuple[float, ...]:
        """Radius of the disks of each section [m]: they enclose all muscles that run through it."""
        own = [_enclosing(routing, law) for routing, law in zip(self.routings, self.laws, strict=True)]
        return tuple(
            max([radius, *(_enclosing(group.routing, group.law) for group in self.groups if group.crosses(number))])
            for number, radius in enumerate(own)
        )

    @cached_property
    def contact_radii(self) -> tuple[float, ...]:
        """Radius of what touches of each section [m]: as given, or of its disks, or of fatter muscles."""
        return tuple(
            section.contact_radius or max([radius, *(group.reach for group in self.groups if group.crosses(number))])
            for number, (section, radius) in enumerate(zip(self.sections, self.disk_radii, strict=True))
        )


def _given(**arguments: Any) -> dict[str, Any]:
    return {name: value for name, value in arguments.items() if value is not OMITTED}


def _tuple(name: str, values: Any, kind: type, count: int | None) -> tuple[Any, ...]:
    """Return the parts of an arm that were given, or so many of the paper's.

    Raises:
        InputError: not a tuple of that kind, none, or not one for each section.
    """
    if values is OMITTED:
        usual = McKibben if kind is MuscleLaw else kind
        return tuple(usual() for _ in range(count or 1))
    allowed = f"a tuple of {kind.__name__}, " + (
        "one or more" if count is None else f"one for each of {count} sections"
    )
    if name == "muscle":
        allowed = "a MuscleLaw, such as McKibben()"
    if not isinstance(values, (tuple, list)) or not all(isinstance(value, kind) for value in values):
        raise InputError(name, values[0] if name == "muscle" else values, allowed)
    if not values or (count is not None and len(values) != count):
        raise InputError(name, f"{len(values)} of them", allowed)
    return tuple(values)


def _enclosing(routing: Routing, law: MuscleLaw) -> float:
    """Return the radius of a disk that encloses muscles [m]."""
    return routing.radius + 0.5 * law.diameter + 0.0015

"""Parameters of an arm by name, one number each: what sweeps vary, what is uncertain, what an environment changes.

length, mass, bending_stiffness, ...      of the section; of several sections, the same for all of them
muscle_radius, muscle.braid_friction      of its muscles and their law
section_2.mass, section_2.muscle.wall     of one of several sections
section_2.muscle.angle_3                  of one of its muscles, counted from muscle.offset
payload, gravity, gravity.z               of the world; a component of a vector
object.post.friction, object.post.position.x   of what the arm can touch, by its name
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass, fields, replace
from typing import Any

from contarm_sim.errors import InputError, did_you_mean
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_table import rerouted
from contarm_sim.model.objects import Object
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.section_tables import said_of
from contarm_sim.model.world import WORLD_PARAMETERS, World

_ROUTED = {"muscle_radius": "radius", "muscle.path": "path", "muscle.count": "count", "muscle.offset": "offset"}
"""Names of where muscles run, and the fields of `Routing` that they are."""

_UNITS = {"path": "-", "count": "-", "offset": "rad"}
"""Units of the fields of `Routing` that declare none."""

_AXES = "xyz"

_OF_OBJECTS = ("position", "size", "radius", "length", "scale", "mass", "friction")
"""Fields of objects that are numbers."""


@dataclass(frozen=True)
class Named:
    """One parameter of an arm.

    Attributes:
        name: what it is called.
        unit: of its value, "-" where it has none.
        kind: the part of the arm that has it: `sections`, `routings`, `laws`, `world` or `objects`.
        owners: numbers of the sections that it is of, from 0, or of the object; none for the world's.
        field: its name in that part.
        component: of a vector, or None.
    """

    name: str
    unit: str
    kind: str
    owners: tuple[int, ...]
    field: str
    component: int | None = None

    def value(self, arm: Arm) -> Any:
        """Return the value that an arm has; of several sections that of the first."""
        part = self._part(arm)
        found = _angles(part) if self.field == "at" else getattr(part, self.field)
        return found if self.component is None else found[self.component]

    def interval(self, arm: Arm) -> tuple[float, float]:
        """Return the bounds as declared, infinite where there are none: least (or above), and below."""
        part = self._part(arm)
        declared = next(item for item in fields(part) if item.name == self.field)
        bounds = declared.metadata.get("bounds") or {}
        low, high = (
            next((bounds[key] for key in ("above", "least") if bounds.get(key) is not None), -math.inf),
            math.inf,
        )
        return low, high if bounds.get("below") is None else bounds["below"]

    def _part(self, arm: Arm) -> Any:
        if self.kind == "world":
            return arm.world
        return getattr(arm.world if self.kind == "objects" else arm, self.kind)[self.owners[0]]


def named_parameters(arm: Arm) -> dict[str, Named]:
    """Return the parameters of an arm by name."""
    every, found = tuple(range(len(arm.sections))), dict(_world())
    for owners, before in [(every, ""), *(((k,), f"section_{k + 1}.") for k in every if len(every) > 1)]:
        for item in fields(Section):
            name = before + item.name
            found[name] = Named(name, item.metadata["unit"], "sections", owners, item.name)
        declared = {item.name: item for item in fields(Routing)}
        for short, field in _ROUTED.items():
            unit = declared[field].metadata.get("unit", _UNITS.get(field, "-"))
            found[before + short] = Named(before + short, unit, "routings", owners, field)
        for place in range(min(arm.routings[k].count for k in owners)):
            name = f"{before}muscle.angle_{place + 1}"
            found[name] = Named(name, "rad", "routings", owners, "at", place)
        for item in fields(arm.laws[owners[0]]):
            if all(hasattr(arm.laws[k], item.name) for k in owners):
                name = f"{before}muscle.{item.name}"
                found[name] = Named(name, item.metadata["unit"], "laws", owners, item.name)
    return found | _objects(arm)


def _objects(arm: Arm) -> dict[str, Named]:
    """Return the numbers of the objects that they have: sizes by their shapes, masses of those that move."""
    found, units = {}, {item.name: item.metadata["unit"] for item in fields(Object) if item.metadata}
    for place, each in enumerate(arm.world.objects):
        for field in _OF_OBJECTS:
            value, before = getattr(each, field), f"object.{each.name}.{field}"
            if value is None or (field == "scale" and each.shape != "mesh"):
                continue
            found[before] = Named(before, units[field], "objects", (place,), field)
            for component, axis in enumerate(_AXES if isinstance(value, tuple) else ""):
                name = f"{before}.{axis}"
                found[name] = Named(name, units[field], "objects", (place,), field, component)
    return found


def _world() -> dict[str, Named]:
    found = {}
    for item in WORLD_PARAMETERS.values():
        unit = item.metadata["unit"]
        found[item.name] = Named(item.name, unit, "world", (), item.name)
        if item.name == "gravity":
            for place, axis in enumerate(_AXES):
                name = f"{item.name}.{axis}"
                found[name] = Named(name, unit, "world", (), item.name, place)
    return found


def find(name: str, known: Mapping[str, Any], where: str | None = None, what: str = "parameter") -> Any:
    """Return what is known by a name.

    Raises:
        InputError: an unknown name; names the nearest known one.
    """
    if name in known:
        return known[name]
    alone = re.sub(r"^section_\d+\.", "", str(name))
    one = alone in known and not any(other.startswith("section_1.") for other in known)
    if what == "parameter" and (own := _of_object(str(name), known)):
        raise InputError(f"{what} {name!r}", "unknown", own, where)
    asked = f"did you mean {alone!r}? The arm has one section. " if one else did_you_mean(name, known)
    every = f"All: {', '.join(known)}" if len(known) < 9 else "contarm sweep SPEC --names lists all"
    raise InputError(f"{what} {name!r}", "unknown", f"{asked}{every}", where)


def _of_object(name: str, known: Mapping[str, Any]) -> str:
    """Return what an object has, where a name is of something that it has not; nothing where it is of no object."""
    kind, owner, field, *_ = [*name.split("."), "", ""]
    own = [each for each in known if each.startswith(f"object.{owner}.") and each.count(".") == 2]
    has = {each.rpartition(".")[2]: each for each in own}
    if kind != "object" or not has:
        return ""
    near = [each for each in has if did_you_mean(field, [each])]
    asked = f"did you mean {has[near[0]]!r}? " if near else ""
    return f"{asked}{owner}{' is fixed, and' if field == 'mass' else ''} has {', '.join(has)}"


def with_parameters(arm: Arm, values: Mapping[str, Any]) -> Arm:
    """Return an arm with parameters changed by name, the later ones last.

    Args:
        values: numbers in SI units (or what the field takes), by the names of `named_parameters`.

    Raises:
        InputError: an unknown name (with the nearest known one), or a value that an arm cannot have.
    """
    known = named_parameters(arm)
    parts: dict[str, list[Any]] = {kind: list(getattr(arm, kind)) for kind in ("sections", "routings", "laws")}
    world, several = arm.world, len(arm.sections) > 1
    for name, value in values.items():
        one = find(name, known)
        if one.kind == "world":
            world = replace(world, **{one.field: _changed(getattr(world, one.field), one.component, value)})
            continue
        if one.kind == "objects":
            world = _with_object(world, one, value)
            continue
        for owner in one.owners:
            with said_of(owner) if several else nullcontext():
                part = parts[one.kind][owner]
                none = one.field.endswith(("friction", "friction_coefficient")) and value == 0
                new = _changed(_angles(part), one.component, value) if one.field == "at" else value
                if one.field == "at" and new == _angles(part):
                    continue  # even spacing stays even spacing
                changes = {one.field: None if none else new}
                parts[one.kind][owner] = rerouted(part, changes) if one.kind == "routings" else replace(part, **changes)
    return replace(
        arm,
        sections=tuple(parts["sections"]),
        routings=tuple(parts["routings"]),
        laws=tuple(parts["laws"]),
        world=world,
    )


def _with_object(world: World, one: Named, value: Any) -> World:
    """Return a world with one number of one object changed."""
    objects, place = list(world.objects), one.owners[0]
    now = objects[place]
    objects[place] = replace(now, **{one.field: _changed(getattr(now, one.field), one.component, value)})
    return replace(world, objects=tuple(objects))


def _angles(routing: Routing) -> tuple[float, ...]:
    """Return the muscles' own angles [rad], counted from `offset`."""
    return tuple(angle - routing.offset for angle in routing.angles) if routing.at is None else routing.at


def _changed(before: Any, component: int | None, value: Any) -> Any:
    if component is None:
        return value
    vector = list(before)
    vector[component] = value
    return tuple(vector)

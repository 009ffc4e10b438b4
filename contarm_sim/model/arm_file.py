"""An arm as TOML: SI units or quantities, muscles in a [muscle] table.

The names of an arm of one section are those of `Arm`. Of several, each has a table [[section]], see `section_tables`;
the world stands at the top of the file.
"""

from __future__ import annotations

import tomllib
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError, one_line
from contarm_sim.inputs import read_text
from contarm_sim.model.arm import Arm
from contarm_sim.model.flat import PARAMETERS
from contarm_sim.model.host_table import HOST_UNITS, host_from_table, host_to_table
from contarm_sim.model.laws import LAWS
from contarm_sim.model.muscle_table import (
    law_to_table,
    muscle_from_table,
    plain,
    refuse_unknown,
    routing_to_table,
)
from contarm_sim.model.object_tables import OBJECT_UNITS, objects_from_tables, objects_to_tables
from contarm_sim.model.objects import Object, said_of_object
from contarm_sim.model.section_tables import PLACED, SECTION, said_of, sections_from_tables, sections_to_tables
from contarm_sim.model.units import quantity, slip
from contarm_sim.model.world import WORLD_PARAMETERS, World

MOST_BYTES = 2**20
"""Largest TOML file that is read [bytes]."""

WORLD = list(WORLD_PARAMETERS)
"""Keys of the world, which stand at the top of every file."""

TOUCHED = ("object", "self_contact", "world")
"""Keys that say what the arm can touch."""


def arm_from_dict(values: dict[str, Any], where: str | None = None, base: Arm | None = None) -> Arm:
    """Return `base` (default: `Arm()`) with the given parameters changed, or the arm whose sections are given.

    Args:
        values: parameters by name; `muscle` holds a dict of its own, `section` a list of dicts.
        where: the file the values came from, for error messages.

    Raises:
        InputError: an unknown name (with the nearest known one), a value out of range, or a parameter of one section
            for an arm of several.
    """
    try:
        rest = {name: value for name, value in values.items() if name not in TOUCHED}
        arm = _of_sections(rest, base) if "section" in values else _of_one(rest, base or Arm())
        return _touching(arm, values, Path(where).parent if where else None)
    except InputError as error:
        raise _within(error, where) from None


def _touching(arm: Arm, values: dict[str, Any], folder: Path | None) -> Arm:
    """Return an arm that can touch what the values say."""
    given: dict[str, Any] = {name: values[name] for name in TOUCHED if name in values}
    if "object" in given:
        given["objects"] = objects_from_tables(given.pop("object"), folder)
    if "world" in given:
        given["host"] = host_from_table(given.pop("world"), folder)
    return arm.in_world(replace(arm.world, **given)) if given else arm


def _of_one(values: dict[str, Any], base: Arm) -> Arm:
    values = dict(values)
    muscle = values.pop("muscle", {})
    refuse_unknown(values, [*PARAMETERS, "muscle", "section", *TOUCHED], "")
    if len(base.sections) > 1 and isinstance(muscle, dict):
        for name, value in muscle.items():
            count = len(base.sections)
            raise InputError(
                f"muscle.{name}", value, f"an arm of one section; this one has {count}: change its sections"
            )
        return replace(base, **values)
    try:
        law, routing = muscle_from_table(muscle, base.laws[0], base.routing)
        return replace(base, routings=(routing,), laws=(law,), **values)
    except InputError as error:
        raise _asking(error, {**values, **_prefixed(muscle)}) from None


def _of_sections(values: dict[str, Any], base: Arm | None) -> Arm:
    for name in values:
        if name in SECTION or name in PLACED:
            allowed = "in each [[section]]; what sections share is in [muscle]"
            raise InputError(f"key {name!r}", "outside of the sections", allowed)
    refuse_unknown(values, [*WORLD, "muscle", "section", *TOUCHED], "")
    world = replace(base.world if base else World(), **{name: values[name] for name in WORLD if name in values})
    shared = values.get("muscle", {})
    try:
        return Arm(**sections_from_tables(values["section"], shared), world=world)
    except InputError as error:
        given = {**values, **_prefixed(shared)}
        if error.where and isinstance(values["section"], list):
            table = values["section"][int(error.where.split()[-1]) - 1]
            given |= {**table, **_prefixed(table.get("muscle", {}))}
        raise _asking(error, given) from None


def _prefixed(muscle: Any) -> dict[str, Any]:
    return {f"muscle.{name}": value for name, value in muscle.items()} if isinstance(muscle, dict) else {}


def _within(error: InputError, where: str | None) -> InputError:
    """Return an error, said to come from a file, and from its part if it names one."""
    return error.located(": ".join(part for part in (where, error.where) if part) or None)


def _asking(error: InputError, values: dict[str, Any]) -> InputError:
    """Return an error, with a question where a value in another unit explains it: 12 is no radius in metres."""
    asked = slip(error.given, units().get(error.name, "-")) if isinstance(error.given, (int, float)) else None
    if asked is None or error.name not in values:
        return error
    return InputError(error.name, error.given, f"{error.allowed}; {asked.partition('; ')[2]}", error.where)


def units() -> dict[str, str]:
    """Return the units of all parameters by their names in TOML, `muscle.` before those of muscles."""
    found = {name: item.metadata["unit"] for name, item in PARAMETERS.items()}
    for law in LAWS.values():
        found |= {f"muscle.{item.name}": item.metadata["unit"] for item in fields(law())}
    found |= {f"world.{name}": unit for name, unit in HOST_UNITS.items()}
    return found | {"muscle.offset": "rad", "muscle.angles": "rad", "muscle_offset": "rad", "muscle_angles": "rad"}


def arm_to_dict(arm: Arm, beside: bool = False) -> dict[str, Any]:
    """Return the parameters of an arm as plain values, see `arm_from_dict`; omitted options are left out.

    Args:
        beside: name the files of meshes as copies that lie beside the arm's.
    """
    touched: dict[str, Any] = {"self_contact": True} if arm.world.self_contact else {}
    host = {"world": host_to_table(arm.world.host)} if arm.world.host is not None else {}
    objects = host | ({"object": objects_to_tables(arm.world.objects, beside)} if arm.world.objects else {})
    if len(arm.sections) > 1:
        world = plain({name: getattr(arm.world, name) for name in WORLD})
        return world | touched | sections_to_tables(arm) | objects
    muscle = law_to_table(arm.laws[0]) | routing_to_table(arm.routing)
    return plain({name: getattr(arm, name) for name in PARAMETERS}) | touched | {"muscle": muscle} | objects


def load_arm(path: str | Path) -> Arm:
    """Read an arm from a TOML file; values are numbers in SI units, or texts with a unit, `length = "250 mm"`.

    Raises:
        InputError: the file cannot be read, is not TOML, or holds an unknown key or a bad value.
    """
    return arm_from_table(_read(path, "lines such as: length = 0.37"), str(path))


def load_objects(path: str | Path) -> tuple[Object, ...]:
    """Read objects from a TOML file that has nothing but tables [[object]].

    Raises:
        InputError: as `load_arm`, or a file with other keys.
    """
    where = str(path)
    values = _read(path, 'tables: [[object]], below each name = "...", shape = "..."')
    try:
        for name in values:
            if name != "object":
                raise InputError(f"key {name!r}", "in a file of objects", "[[object]] alone; the rest is in the arm's")
        return objects_from_tables(_in_si(values, {}).get("object", []), Path(path).parent)
    except InputError as error:
        raise _within(error, where) from None


def _read(path: str | Path, lines: str) -> dict[str, Any]:
    """Return what a TOML file holds.

    Raises:
        InputError: it cannot be read, or is not TOML.
    """
    text = read_text(path, "a TOML file", MOST_BYTES)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # TOMLDecodeError is a ValueError, as is a number of 5000 digits
        given = f"not TOML ({one_line(str(error), 80)})"
        raise InputError("file", given, lines, str(path)) from error


def arm_from_table(values: dict[str, Any], where: str) -> Arm:
    """Return the arm that a table of TOML holds: texts may have units.

    Raises:
        InputError: as `arm_from_dict`.
    """
    try:
        in_si = _in_si(values, units())
    except InputError as error:
        raise _within(error, where) from None
    return arm_from_dict(in_si, where)


def _in_si(values: dict[str, Any], known: dict[str, str], prefix: str = "") -> dict[str, Any]:
    """Return values with quantities, which TOML holds as texts, as numbers in SI units."""

    def one(name: str, value: Any) -> Any:
        if isinstance(value, dict) and not prefix:
            return _in_si(value, known, f"{name}.")
        if name == "section" and not prefix and isinstance(value, list):
            return [_section_in_si(number, table, known) for number, table in enumerate(value)]
        if name == "object" and not prefix and isinstance(value, list):
            return [_object_in_si(number, table) for number, table in enumerate(value)]
        if isinstance(value, list) and any(isinstance(x, str) for x in value):
            return [one(name, x) if isinstance(x, str) else x for x in value]
        unit = known.get(prefix + name, "-")
        if not isinstance(value, str) or unit == "-":
            return value
        if not value.strip().strip("+-").lower().strip("0123456789.e+-"):
            raise InputError(prefix + name, repr(value), f"a number without quotes [{unit}], or a text with its unit")
        return quantity(value, unit, prefix + name)

    return {name: one(name, value) for name, value in values.items()}


def _section_in_si(number: int, table: Any, known: dict[str, str]) -> Any:
    """Return a table [[section]] in SI units; parameters of its law may stand beside those of the section."""
    if not isinstance(table, dict):
        return table
    beside = {name.removeprefix("muscle."): unit for name, unit in known.items()}
    with said_of(number):
        return _in_si(table, {**beside, **known})


def _object_in_si(number: int, table: Any) -> Any:
    """Return a table [[object]] in SI units."""
    if not isinstance(table, dict):
        return table
    try:
        return _in_si(table, OBJECT_UNITS, "")
    except InputError as error:
        raise error.located(said_of_object(table.get("name", number + 1))) from None


def arm_to_toml(arm: Arm, beside: bool = False) -> str:
    """Return the arm as TOML text; `load_arm` reads it back to an equal arm.

    Args:
        beside: name the files of meshes as copies that lie beside the text's.
    """
    import tomli_w

    return tomli_w.dumps(arm_to_dict(arm, beside))

"""The tables [[section]] of an arm in TOML, from the base to the tip, and what they share in [muscle]."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.laws import law_name
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.muscle_table import (
    ROUTED,
    law_fields,
    law_of,
    law_to_table,
    muscle_from_table,
    plain,
    refuse_unknown,
    rerouted,
)
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import MAX_SECTIONS, Section

SECTION = [item.name for item in fields(Section)]
"""Keys of [[section]] that are fields of `Section`."""

PLACED = {
    "muscle_radius": "radius", "muscle_count": "count", "muscle_offset": "offset", "muscle_angles": "at",
    "muscle_from": "start",
}  # fmt: skip
"""Keys of [[section]] that say where its muscles run, and the fields of `Routing` that they are."""

_HOW_MANY = {"count", "at"}
"""Fields of `Routing` that say how many muscles there are: given once."""

_HERE = {f"muscle.{name}": here for here, field in PLACED.items() for name, same in ROUTED.items() if same == field}


@contextmanager
def said_of(number: int) -> Iterator[None]:
    """Say of which section, numbered from 0, an error speaks."""
    try:
        yield
    except InputError as error:
        raise error.located(f"section {number + 1}") from None


def sections_from_tables(tables: Any, shared: Any) -> dict[str, Any]:
    """Return the sections, routings and laws of an arm, as arguments of `Arm`.

    A section with a law of its own name takes nothing of the shared law, only where the shared muscles run.

    Args:
        tables: what [[section]] holds, a list of dicts.
        shared: what [muscle] holds.

    Raises:
        InputError: an unknown key (with the nearest known one), or a value out of range; says of which section.
    """
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables) or not tables:
        raise InputError("section", tables, "tables, [[section]], one for each section from the base to the tip")
    if len(tables) > MAX_SECTIONS:
        raise InputError("section", f"{len(tables)} tables", f"at most {MAX_SECTIONS}")
    law, routing = muscle_from_table(shared, McKibben(), Routing())
    made = []
    for number, table in enumerate(tables):
        with said_of(number):
            made.append(_section(table, law, routing))
    sections, routings, laws = zip(*made, strict=True)
    return {"sections": sections, "routings": routings, "laws": laws}


def _section(table: dict[str, Any], law: MuscleLaw, routing: Routing) -> tuple[Section, Routing, MuscleLaw]:
    own, muscle = dict(table), table.get("muscle", {})
    own.pop("muscle", None)
    if not isinstance(muscle, dict):
        raise InputError("muscle", muscle, "a table, [section.muscle]")
    law = law_of(muscle.get("law", own.get("law")), law)
    direct = ["law", "path", *law_fields(law)]
    refuse_unknown(own, [*SECTION, *PLACED, *direct, "muscle"], "")
    placed = {name: own.pop(name) for name in PLACED if name in own}
    beside = {name: own.pop(name) for name in direct if name in own}
    fields_placed = {PLACED[name] for name in placed}
    if fields_placed & _HOW_MANY:
        fields_placed |= _HOW_MANY
    twice = [name for name in muscle if name in beside or ROUTED.get(name) in fields_placed]
    if twice:
        raise InputError(f"muscle.{twice[0]}", "given twice", "in [[section]] or in [section.muscle]")
    section = Section(**own)
    law, routing = muscle_from_table({**beside, **muscle}, law, routing)
    try:
        return section, rerouted(routing, {PLACED[name]: value for name, value in placed.items()}), law
    except InputError as error:  # Python and [muscle] say muscle.count
        raise InputError(_HERE.get(error.name, error.name), error.given, error.allowed) from None


def sections_to_tables(arm: Arm) -> dict[str, Any]:
    """Return [muscle] and [[section]] of an arm: what `sections_from_tables` reads, shared values once."""
    shared = _shared_law(arm)
    paths = {routing.path for routing in arm.routings}
    path = paths.pop() if len(paths) == 1 else None
    tables = []
    for section, routing, law in zip(arm.sections, arm.routings, arm.laws, strict=True):
        table = plain({name: getattr(section, name) for name in SECTION})
        own = {name: x for name, x in law_to_table(law).items() if shared.get(name) != x}
        if type(law) is not type(arm.laws[0]):
            own = {"law": law_name(law)} | law_to_table(law)
        placed = {name: getattr(routing, field) for name, field in PLACED.items()}
        if routing.at is not None:
            del placed["muscle_count"]
        if path is None:
            own["path"] = routing.path
        tables.append(table | plain(placed) | ({"muscle": own} if own else {}))
    muscle = shared | ({"path": path} if path else {})
    return {"muscle": muscle, "section": tables}


def _shared_law(arm: Arm) -> dict[str, Any]:
    """Return what all laws of the first one's kind have in common; an option that one of them omits is not shared."""
    first = arm.laws[0]
    alike = [law_to_table(law) for law in arm.laws if type(law) is type(first)]
    return {name: x for name, x in alike[0].items() if all(name in one and one[name] == x for one in alike)}

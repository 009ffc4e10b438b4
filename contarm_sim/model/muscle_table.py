"""The table [muscle] of an arm in TOML: the law, its parameters, and where the muscles run."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.laws import LAWS, law_name
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.routing import Routing

ROUTED = {"path": "path", "count": "count", "offset": "offset", "angles": "at", "start": "start"}
"""Keys of [muscle] that say where muscles run, and the fields of `Routing` that they are."""


def muscle_from_table(table: Any, law: MuscleLaw, routing: Routing) -> tuple[MuscleLaw, Routing]:
    """Return a law and a routing with what a table changes; another law begins from its own defaults.

    Raises:
        InputError: not a table, an unknown key (with the nearest known one), or a value out of range.
    """
    if not isinstance(table, dict):
        raise InputError("muscle", table, "a table, [muscle]")
    law = law_of(table.get("law"), law)
    own = law_fields(law)
    refuse_unknown(table, ["law", *own, *ROUTED], "muscle.")
    law = replace(law, **{name: value for name, value in table.items() if name in own})
    return law, rerouted(routing, {field: table[name] for name, field in ROUTED.items() if name in table})


def rerouted(routing: Routing, changes: dict[str, Any]) -> Routing:
    """Return a routing with other fields; a new count spaces muscles evenly, new angles count them."""
    if "count" in changes and "at" not in changes:
        changes = {**changes, "at": None}
    elif "at" in changes and "count" not in changes:
        changes = {**changes, "count": Routing.count}
    return replace(routing, **changes) if changes else routing


def law_of(name: Any, base: MuscleLaw) -> MuscleLaw:
    """Return the law of a name with its defaults; `base` if there is no name, or it is that of `base`.

    Raises:
        InputError: an unknown name.
    """
    if name is None or name == law_name(base):
        return base
    if not isinstance(name, str) or name not in LAWS:
        raise InputError("muscle.law", name, f"{', '.join(LAWS)}, or one put into contarm_sim.model.laws.LAWS before")
    return LAWS[name]()


def law_fields(law: MuscleLaw) -> list[str]:
    """Return the names of a law's parameters."""
    return [item.name for item in fields(law)]


def law_to_table(law: MuscleLaw) -> dict[str, Any]:
    """Return a law's parameters, its name first unless it is the default; omitted options are left out."""
    name = {} if type(law) is McKibben else {"law": law_name(law)}
    return name | plain({name: getattr(law, name) for name in law_fields(law)})


def routing_to_table(routing: Routing) -> dict[str, Any]:
    """Return where muscles run, by keys of [muscle]: the path, and what is not the default."""
    usual = Routing(path=routing.path)
    count = {} if routing.at is not None else {"count": "count"}
    keys = {"path": "path", **count, "offset": "offset", "angles": "at", "start": "start"}
    found = {name: getattr(routing, field) for name, field in keys.items()}
    return plain({name: x for name, x in found.items() if name == "path" or x != getattr(usual, keys[name])})


def plain(values: dict[str, Any]) -> dict[str, Any]:
    """Return values as TOML and JSON have them, those that are None left out."""
    given = {key: value for key, value in values.items() if value is not None}
    return {key: list(value) if isinstance(value, tuple) else value for key, value in given.items()}


def refuse_unknown(values: Mapping[str, Any], known: Sequence[str], prefix: str = "", where: str | None = None) -> None:
    """Refuse keys that are not known.

    Raises:
        InputError: names the nearest known key.
    """
    for name in values:
        if name not in known:
            near = difflib.get_close_matches(str(name)[:100], known, n=1, cutoff=0.0)[0]
            allowed = f"did you mean {prefix + near!r}? All: {', '.join(known)}"
            raise InputError(f"key {prefix + str(name)!r}", "unknown", allowed, where)

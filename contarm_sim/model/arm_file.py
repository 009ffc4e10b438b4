"""An arm as TOML: the names are those of `Arm`, muscle parameters in a [muscle] table, SI units or quantities."""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import Field, fields, replace
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError, one_line
from contarm_sim.inputs import read_text
from contarm_sim.model.arm import Arm
from contarm_sim.model.flat import MUSCLE_PARAMETERS, PARAMETERS
from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.laws import LAWS, law_name
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.routing import Routing
from contarm_sim.model.units import quantity, slip

MOST_BYTES = 2**20
"""Largest TOML file that is read [bytes]."""

_ROUTED = ("count", "offset", "start")
"""Keys of [muscle] beside the parameters that are flags: of the routing, left out where they are the default's."""


def arm_from_dict(values: dict[str, Any], where: str | None = None, base: Arm | None = None) -> Arm:
    """Return `base` (default: `Arm()`), an arm of one section, with the given parameters changed.

    Args:
        values: parameters by name; `muscle` holds a dict of its own.
        where: the file the values came from, for error messages.

    Raises:
        InputError: an unknown name (with the nearest known one), or a value out of range.
    """
    base = base or Arm()
    values = dict(values)
    muscle = values.pop("muscle", {})
    if not isinstance(muscle, dict):
        raise InputError("muscle", muscle, "a table, [muscle]", where)
    _refuse_unknown(values, [*PARAMETERS, "muscle"], "", where)
    try:
        law = _law(muscle.get("law"), base.laws[0])
        own = [item.name for item in fields(law)]
        _refuse_unknown(muscle, ["law", *own, "path", *_ROUTED], "muscle.", where)
        routed = {name: muscle[name] for name in ("path", *_ROUTED) if name in muscle}
        law = replace(law, **{name: value for name, value in muscle.items() if name in own})
        return replace(base, routings=(replace(base.routing, **routed),), laws=(law,), **values)
    except InputError as error:
        raise _asking(error, {**values, **{f"muscle.{name}": x for name, x in muscle.items()}}).located(where) from None


def _law(name: Any, base: MuscleLaw) -> MuscleLaw:
    """Return the law of a name with its defaults; `base` if there is no name, or it is that of `base`.

    Raises:
        InputError: an unknown name.
    """
    if name is None or name == law_name(base):
        return base
    if not isinstance(name, str) or name not in LAWS:
        raise InputError("muscle.law", name, f"{', '.join(LAWS)}, or one put into contarm_sim.model.laws.LAWS before")
    return LAWS[name]()


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
    return found | {"muscle.offset": "rad"}


def _refuse_unknown(values: dict[str, Any], known: list[str], prefix: str, where: str | None) -> None:
    for name in values:
        if name not in known:
            near = difflib.get_close_matches(str(name)[:100], known, n=1, cutoff=0.0)[0]
            allowed = f"did you mean {prefix + near!r}? All: {', '.join(known)}"
            raise InputError(f"key {prefix + str(name)!r}", "unknown", allowed, where)


def arm_to_dict(arm: Arm) -> dict[str, Any]:
    """Return the parameters of an arm of one section as plain values; omitted options are left out.

    Raises:
        InputError: an arm of several sections.
    """
    routing, usual = arm.routing, Routing()
    law = {item.name: getattr(arm.muscle, item.name) for item in fields(arm.muscle)}
    muscle = {**({} if type(arm.muscle) is McKibben else {"law": law_name(arm.muscle)}), **law, "path": routing.path}
    muscle |= {name: getattr(routing, name) for name in _ROUTED if getattr(routing, name) != getattr(usual, name)}
    return _plain({name: getattr(arm, name) for name in PARAMETERS}) | {"muscle": _plain(muscle)}


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    given = {key: value for key, value in values.items() if value is not None}
    return {key: list(value) if isinstance(value, tuple) else value for key, value in given.items()}


def load_arm(path: str | Path) -> Arm:
    """Read an arm from a TOML file; values are numbers in SI units, or texts with a unit, `length = "250 mm"`.

    Raises:
        InputError: the file cannot be read, is not TOML, or holds an unknown key or a bad value.
    """
    text = read_text(path, "a TOML file", MOST_BYTES)
    try:
        values = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # TOMLDecodeError is a ValueError, as is a number of 5000 digits
        given = f"not TOML ({one_line(str(error), 80)})"
        raise InputError("file", given, "lines such as: length = 0.37", str(path)) from error
    try:
        return arm_from_dict(_in_si(values, units()), str(path))
    except InputError as error:
        raise error if error.where else error.located(str(path)) from None


def _in_si(values: dict[str, Any], known: dict[str, str], prefix: str = "") -> dict[str, Any]:
    """Return values with quantities, which TOML holds as texts, as numbers in SI units."""

    def one(name: str, value: Any) -> Any:
        if isinstance(value, dict) and not prefix:
            return _in_si(value, known, f"{name}.")
        if isinstance(value, list) and any(isinstance(x, str) for x in value):
            return [one(name, x) if isinstance(x, str) else x for x in value]
        unit = known.get(prefix + name, "-")
        if not isinstance(value, str) or unit == "-":
            return value
        if not value.strip().strip("+-").lower().strip("0123456789.e+-"):
            raise InputError(prefix + name, repr(value), f"a number without quotes [{unit}], or a text with its unit")
        return quantity(value, unit, prefix + name)

    return {name: one(name, value) for name, value in values.items()}


def arm_to_toml(arm: Arm) -> str:
    """Return the arm as TOML text; `load_arm` reads it back to an equal arm."""
    import tomli_w

    return tomli_w.dumps(arm_to_dict(arm))


def arm_template(arm: Arm) -> str:
    """Return the arm as TOML text to be edited: every parameter with its meaning, unit and default."""
    head = [
        '# An arm for contarm_sim. Numbers are in SI units; with another unit write a text: length = "370 mm".',
        "# A line that begins with # is left out. Parameters that are left out have their defaults.",
    ]
    values = arm_to_dict(arm)
    muscle = values.pop("muscle")
    rest = {name: value for name, value in muscle.items() if name not in MUSCLE_PARAMETERS}
    lines = [*head, *_entries(PARAMETERS, values), "", "[muscle]", *_entries(MUSCLE_PARAMETERS, muscle)]
    return "\n".join([*lines, *(f"{name} = {_flat(value)}" for name, value in rest.items())]) + "\n"


def _entries(parameters: dict[str, Field[Any]], values: dict[str, Any]) -> list[str]:
    """Return the lines of a table: a comment and a key for each parameter; one without a value is a comment too."""
    lines = []
    for name, item in parameters.items():
        unit, choices = item.metadata["unit"], item.metadata.get("choices")
        default = "left out" if item.default is None else _flat(item.default)
        kind = f", one of {', '.join(choices)}" if choices else "" if unit == "-" else f" [{unit}]"
        lines += ["", f"# {item.metadata['help']}{kind}; default: {default}"]
        lines.append(f"{name} = {_flat(values[name])}" if name in values else f"# {name} =")
    return lines


def _flat(value: Any) -> str:
    """Return a value as TOML writes it, lists on one line."""
    import tomli_w

    text = tomli_w.dumps({"x": list(value) if isinstance(value, tuple) else value}).removeprefix("x = ")
    return " ".join(text.split()).replace("[ ", "[").replace(", ]", "]")

"""An arm as a TOML file to be edited: every parameter with its meaning, unit and default."""

from __future__ import annotations

from dataclasses import Field, fields
from typing import Any

from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_to_dict
from contarm_sim.model.flat import PARAMETERS
from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.laws import LAWS
from contarm_sim.model.objects import SHAPES
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.section_tables import PLACED
from contarm_sim.model.world import WORLD_PARAMETERS

_HEAD = [
    '# An arm for contarm_sim. Numbers are in SI units; with another unit write a text: length = "370 mm".',
    "# A line that begins with # is left out. Parameters that are left out have their defaults.",
]
_SEVERAL = [
    "# Each [[section]] is a section, from the base to the tip. All share what [muscle] says; a section may say",
    "# otherwise in a table [section.muscle] after its own lines.",
]

_TOUCH = [
    "# What the arm can touch, a table for each object. Vectors are in the base frame: +Z runs along the straight arm,",
    "# down where it hangs. Without # these lines are a post:",
    "",
    "# [[object]]",
    '# name = "post"',
    f'# shape = "cylinder"  # one of {", ".join(SHAPES)}',
    "# radius = 0.01  # of spheres, capsules and cylinders [m]",
    "# length = 0.4  # of capsules and cylinders [m]; boxes have size = [x, y, z], meshes a file",
    "# position = [0.1, 0.0, 0.25]  # of its middle [m]; a plane runs through it",
    "# axis = [0.0, 1.0, 0.0]  # direction of its own Z: along cylinders, out of planes",
    "# friction = 0.8",
    "# mass = 0.05  # of an object that moves [kg]; left out: it stays where it is",
]

_RADIUS = {item.name: item for item in fields(Routing)}["radius"]
_PATH = {item.name: item for item in fields(Routing)}["path"]

_PLACED = {
    "muscle_count": "number of muscles, evenly spaced, 2 to 6, or 0; default: 3",
    "muscle_offset": "angle of the first muscle about +Z from +X [rad]; default: 0.0",
    "muscle_angles": "angles of the muscles from muscle_offset on [rad], in place of muscle_count; default: left out",
    "muscle_from": "where muscles begin: at the base of their section, or of the arm; one of section, base",
}
"""What parameters mean that have no flags."""


def arm_template(arm: Arm) -> str:
    """Return the arm as TOML text to be edited, which `load_arm` reads back to an equal arm."""
    values = arm_to_dict(arm)
    muscle, sections = values.pop("muscle"), values.pop("section", None)
    objects, host = values.pop("object", []), values.pop("world", {})
    touched = ["", "# whether the arm's links touch one another; default: false"]
    touched += _short({"self_contact": True}) if values.pop("self_contact", False) else ["# self_contact ="]
    if sections is None:
        lines = [*_HEAD, *_entries(PARAMETERS, values), *touched, "", "[muscle]", *_muscle(arm.laws[0], muscle)]
        return "\n".join([*lines, *_objects(objects, host)]) + "\n"
    lines = [
        *_HEAD,
        *_SEVERAL,
        *_entries(WORLD_PARAMETERS, values),
        *touched,
        "",
        "[muscle]",
        *_muscle(arm.laws[0], muscle),
    ]
    for number, table in enumerate(sections):
        lines += ["", "[[section]]", *(_section(table) if number == 0 else _short(table))]
        if "muscle" in table:
            lines += ["", "[section.muscle]", *_short(table["muscle"])]
    return "\n".join([*lines, *_objects(objects, host)]) + "\n"


def _objects(tables: list[dict[str, Any]], host: dict[str, Any]) -> list[str]:
    """Return the lines of what the arm can touch, an example in comments where that is nothing, and of its host."""
    world = ["", "[world]", *_short(host)] if host else []
    return world + ([line for table in tables for line in ("", "[[object]]", *_short(table))] or ["", *_TOUCH])


def _muscle(law: MuscleLaw, table: dict[str, Any]) -> list[str]:
    """Return the lines of [muscle]: the law, its parameters and the path, and what has no flag."""
    chosen = [f"law = {_flat(table['law'])}  # one of {', '.join(LAWS)}"] if "law" in table else []
    known = {**{item.name: item for item in fields(law)}, "path": _PATH}
    rest = {name: value for name, value in table.items() if name not in known and name != "law"}
    return [*chosen, *_entries(known, table), *_short(rest)]


def _section(table: dict[str, Any]) -> list[str]:
    """Return the lines of the first section, with the meaning of each."""
    lines = _entries({**{item.name: item for item in fields(Section)}, "muscle_radius": _RADIUS}, table)
    for name in PLACED:
        if name in _PLACED:
            lines += ["", f"# {_PLACED[name]}", f"{name} = {_flat(table[name])}" if name in table else f"# {name} ="]
    return lines


def _short(table: dict[str, Any]) -> list[str]:
    """Return the lines of a table whose parameters are explained before."""
    return [f"{name} = {_flat(value)}" for name, value in table.items() if not isinstance(value, dict)]


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

"""What the cases of a sweep may differ in, by name: parameters of the arm, and of what it does.

length, bending_stiffness, muscle.wall, section_2.mass, payload, gravity.z ...   of the arm, as `model.named` has them
controller, grid, max_bend, bend.angle, bend.plane, section_2.bend.angle ...     of poses at rest
load.force.x, load.at, load.pressures.1, bend.angle ...                          of a load
controller, path.name, path.duration, path.max_bend, timestep ...                of a motion
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from inspect import signature
from typing import Any, Literal, get_args

from contarm_sim import paths
from contarm_sim.control.registry import NAMES as CONTROLLERS
from contarm_sim.errors import InputError
from contarm_sim.mechanics import muscles
from contarm_sim.model.arm import Arm
from contarm_sim.model.named import named_parameters
from contarm_sim.model.parameters import as_number, as_numbers
from contarm_sim.model.pneumatic_law import PneumaticLaw

Run = Literal["rest", "equilibrium", "motion"]
RUNS: tuple[Run, ...] = get_args(Run)
"""What a case does: poses at rest over many bends, one pose at rest under a load, or a motion along a path."""

Kind = Literal["number", "whole", "text", "vector"]

GRID, MAX_BEND = 4, math.radians(120)
"""Bend angles, with three times as many planes, of the poses at rest of a case; the largest of them [rad]."""

MOST_GRID = 40
"""Most bend angles of the poses at rest of a case."""

_MEMORY = ("friction_moment", "friction_stiffness", "friction_coefficient")
"""Ends of names of friction that remembers: poses at rest leave it out, simulated motions refuse it."""

_MOVING = ("damping_time", "joint_friction", "friction", "braid_friction", "valve_time", "servo_time")
"""Ends of names of what else changes nothing at rest."""

_PROJECT = ("refuse", "nearest", "ray", "paper")


@dataclass(frozen=True)
class Parameter:
    """Something that cases may differ in.

    Attributes:
        name: what it is called.
        unit: of its value, "-" where it has none.
        kind: what its values are.
        size: of a vector.
        choices: texts that it may be; empty for any.
        of_arm: whether an arm has it, or what the arm does.
        idle: why it cannot vary, such as that it changes nothing of what a case does; or nothing.
    """

    name: str
    unit: str
    kind: Kind = "number"
    size: int = 1
    choices: tuple[str, ...] = ()
    of_arm: bool = False
    idle: str = ""

    @property
    def meant(self) -> str:
        """What its values are, in words."""
        if self.choices:
            return ", ".join(self.choices)
        return {"number": "a number", "whole": "a whole number", "text": "a text"}.get(
            self.kind, f"{self.size} numbers"
        )

    def checked(self, value: Any) -> Any:
        """Return a value as a float, a whole number, a text or a tuple of floats.

        Raises:
            InputError: it is of another kind.
        """
        if self.kind == "text":
            if not isinstance(value, str) or (self.choices and value not in self.choices):
                raise InputError(self.name, value, ", ".join(self.choices) or "a text")
            return value
        if self.kind == "vector":
            numbers = as_numbers(value)
            if numbers is None or len(numbers) != self.size:
                raise InputError(self.name, value, f"{self.size} finite numbers")
            return numbers
        number = as_number(value)
        if not math.isfinite(number) or (self.kind == "whole" and number != round(number)):
            raise InputError(self.name, value, "a whole number" if self.kind == "whole" else "a finite number")
        return round(number) if self.kind == "whole" else number

    def drawn(self, value: Any) -> Any:
        """Return a value that was drawn from a range or a distribution: whole numbers are the nearest."""
        return round(value) if self.kind == "whole" else value


def known_names(arm: Arm, run: Run) -> dict[str, Parameter]:
    """Return what cases of a run may differ in, by name."""
    found = [_of_arm(name, named.unit, named.value(arm)) for name, named in named_parameters(arm).items()]
    if run == "motion":
        idle = dict.fromkeys(_MEMORY, "unknown to simulated motions: they refuse it")
    else:
        idle = dict.fromkeys((*_MEMORY, *_MOVING), "without effect where nothing moves")
    idle["base_orientation"] = "without effect but in pictures"
    found = [replace(one, idle=idle.get(one.name.rpartition(".")[2], "")) for one in found]
    found += {"rest": _rest, "equilibrium": _equilibrium, "motion": _motion}[run](arm)
    return {parameter.name: parameter for parameter in found}


def _of_arm(name: str, unit: str, value: Any) -> Parameter:
    if isinstance(value, str):
        return Parameter(name, unit, "text", of_arm=True)
    if isinstance(value, int) and not isinstance(value, bool):
        return Parameter(name, unit, "whole", of_arm=True)
    if isinstance(value, tuple) or name == "base_orientation":
        return Parameter(name, unit, "vector", 4 if name == "base_orientation" else len(value), of_arm=True)
    return Parameter(name, unit, of_arm=True)


def _vector(name: str, unit: str, size: int, parts: str | None = None) -> list[Parameter]:
    """Return a vector and its components, by letters or by number from 1."""
    ends = parts or [str(number + 1) for number in range(size)]
    return [Parameter(name, unit, "vector", size), *(Parameter(f"{name}.{end}", unit) for end in ends)]


def _bends(arm: Arm) -> list[Parameter]:
    """Return the bend of all sections alike, and of each of several."""
    fronts = [""] + [f"section_{k + 1}." for k in range(len(arm.sections)) if len(arm.sections) > 1]
    return [Parameter(f"{front}bend.{angle}", "rad") for front in fronts for angle in ("angle", "plane")]


def _rest(arm: Arm) -> list[Parameter]:
    return [
        Parameter("controller", "-", "text", choices=CONTROLLERS),
        Parameter("grid", "-", "whole"),
        Parameter("max_bend", "rad"),
        *_bends(arm),
    ]


def _equilibrium(arm: Arm) -> list[Parameter]:
    count = muscles.count(arm)
    driven = [each for kind, unit in DRIVEN.items() for each in _vector(f"load.{kind}", unit, count)]
    if not all(isinstance(law, PneumaticLaw) for law in arm.laws):
        none = "of muscles that have no pressure"
        driven = [replace(one, idle=none if one.unit == DRIVEN["pressures"] else "") for one in driven]
    return [
        *_vector("load.force", "N", 3, "xyz"),
        *_vector("load.moment", "N m", 3, "xyz"),
        Parameter("load.at", "-"),
        *_vector("load.follower_moment", "N m", 3, "xyz"),
        *_vector("load.actuation_moment", "N m", 2, "xy"),
        *driven,
        *_bends(arm),
    ]


DRIVEN = {"deltas": "m", "tensions": "N", "pressures": "Pa"}
"""How muscles may be driven, one number each, and its unit."""


def _motion(arm: Arm) -> list[Parameter]:
    units = {"duration": "s", "max_bend": "rad", "sphere_radius": "m", "sphere_centre": "m"}
    found = [Parameter("controller", "-", "text", choices=CONTROLLERS), Parameter("timestep", "s")]
    found.append(Parameter("path.name", "-", "text", choices=paths.NAMES))
    for name in signature(paths.named).parameters:
        if name == "sphere_centre":
            found += _vector(f"path.{name}", units[name], 3, "xyz")
        elif name not in ("name", "length"):
            found.append(Parameter(f"path.{name}", units.get(name, "-")))
    found.append(Parameter("path.project", "-", "text", choices=_PROJECT))
    return [*found, *_vector("path.direction", "-", 3, "xyz")]

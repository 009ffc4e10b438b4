"""What one case is: an arm, and what it does, as its parameters say."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim import paths
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.model.named import with_parameters
from contarm_sim.model.parameters import check_count
from contarm_sim.motion.time_step import Stepping
from contarm_sim.paths.reference import RATE, Reference
from contarm_sim.studies.scenarios import dome_grid, spread_bends
from contarm_sim.sweeps.names import DRIVEN, GRID, MAX_BEND, MOST_GRID
from contarm_sim.sweeps.spec import Spec

Options = dict[str, Any]

_BEND = ".bend."
_APART = ("name", "project", "direction", "sphere_centre")


@dataclass(frozen=True, eq=False)
class Case:
    """An arm, and what it does.

    Attributes:
        arm: with the parameters of the case.
        options: what is not of the arm, by name.
    """

    arm: Arm
    options: Options

    @property
    def controller(self) -> Any:
        """Name of the controller."""
        return self.options.get("controller", "servo")

    def load(self) -> Load:
        """Return the load of an equilibrium."""
        given = self.options
        wrench = Wrench(
            xi=given.get("load.at", 1.0),
            force=_vector(given, "load.force", 3, "xyz"),
            moment=_vector(given, "load.moment", 3, "xyz"),
        )
        return Load(
            wrenches=(wrench,) if any(wrench.force) or any(wrench.moment) else (),
            follower_moment=_vector(given, "load.follower_moment", 3, "xyz"),
            actuation_moment=_vector(given, "load.actuation_moment", 2, "xy"),
            muscles=_muscles(given, self.arm),
        )

    def poses(self) -> Reference:
        """Return the bends of poses at rest: one, or a grid over the dome, as `contarm validate` has it."""
        bend, arm = bend_of(self.options, self.arm), self.arm
        if bend is not None:
            return Reference.from_bends(bend[None], arm)
        grid, most = self.options.get("grid", GRID), self.options.get("max_bend", MAX_BEND)
        several = len(arm.sections) > 1
        return Reference.from_bends(spread_bends(arm, 3 * grid**2, most) if several else dome_grid(grid, most), arm)

    def path(self) -> paths.Path:
        """Return the path of a motion."""
        given = {name[5:]: value for name, value in self.options.items() if name.startswith("path.")}
        shape = {name: value for name, value in given.items() if "." not in name and name not in _APART}
        if any(name.startswith("sphere_centre") for name in given):
            shape["sphere_centre"] = _vector(given, "sphere_centre", 3, "xyz")
        return paths.named(given.get("name", "spiral"), self.arm.length, **shape)

    def motion(self) -> Reference:
        """Return the motion along the path."""
        direction = None
        if any(name.startswith("path.direction") for name in self.options):
            direction = _vector(self.options, "path.direction", 3, "xyz")
        project = self.options.get("path.project", "refuse")
        return Reference.from_path(self.path(), self.arm, project=project, direction=direction)

    def stepping(self) -> Stepping | None:
        """Return how the engine steps; None where that is to be found."""
        timestep = self.options.get("timestep")
        return None if timestep is None else Stepping(timestep)


def case_of(spec: Spec, values: Mapping[str, Any]) -> Case:
    """Return the case in which parameters have these values.

    Raises:
        InputError: no arm has them.
    """
    every = {**spec.fixed, **values}
    of_arm = {name: value for name, value in every.items() if spec.known[name].of_arm}
    return Case(with_parameters(spec.arm, of_arm), options_of(spec, every))


def options_of(spec: Spec, values: Mapping[str, Any]) -> Options:
    """Return what is not of the arm, checked.

    Raises:
        InputError: a value out of range, or options that exclude one another.
    """
    given = {name: value for name, value in values.items() if not spec.known[name].of_arm}
    refuse_both(given)
    check_count("grid", given.get("grid", 1), 1)
    if given.get("grid", 1) > MOST_GRID:
        raise InputError("grid", given["grid"], f"at most {MOST_GRID}")
    if not 0 < given.get("max_bend", 1.0) <= LARGEST_BEND:
        raise InputError("max_bend", given["max_bend"], f"more than 0 and at most {LARGEST_BEND:.4g} rad (170 deg)")
    if not 0 <= given.get("load.at", 1.0) <= 1:
        raise InputError("load.at", given["load.at"], "a number from 0 (base) to 1 (tip)")
    if "timestep" in given:
        Stepping(given["timestep"]).substeps(RATE)
    case = Case(spec.arm, given)
    if spec.run == "equilibrium":
        case.load()
    elif spec.run == "motion":
        case.path()
    else:
        bend_of(given, spec.arm)
    return given


def refuse_both(names: Iterable[str]) -> None:
    """Refuse names of options that exclude one another.

    Raises:
        InputError: muscles that are driven twice, or one bend beside a grid of them.
    """
    driven = {kind for kind in DRIVEN if any(f"{name}.".startswith(f"load.{kind}.") for name in names)}
    driven |= {"bend" for name in names if _BEND in f".{name}"}
    if len(driven) > 1:
        raise InputError("muscles", f"driven by {' and by '.join(sorted(driven))}", "one of them")
    if "bend" in driven:
        for name in ("grid", "max_bend"):
            if name in names:
                raise InputError(name, "given", "left out beside one bend, bend.angle and bend.plane")


def _vector(given: Options, name: str, size: int, parts: str) -> Any:
    """Return a vector with its components that are given apart."""
    found = list(given.get(name, (0.0,) * size))
    for place, part in enumerate(parts):
        found[place] = given.get(f"{name}.{part}", found[place])
    return tuple(found)


def bend_of(given: Options, arm: Arm) -> Array | None:
    """Return the bend of all sections [rad], shape (2 S,); None where none is given."""
    if not any(_BEND in f".{name}" for name in given):
        return None
    made = []
    for k in range(len(arm.sections)):
        own = {"angle": 0.0, "plane": 0.0}
        for part in own:
            for name in (f"bend.{part}", f"section_{k + 1}.bend.{part}"):
                own[part] = given.get(name, own[part])
        if not 0 <= own["angle"] < np.pi:
            raise InputError("bend.angle", own["angle"], "0 <= bend angle < pi rad (180 deg)")
        made.append(arc.from_polar(own["angle"], own["plane"]))
    return np.concatenate(made)


def _muscles(given: Options, arm: Arm) -> Muscles:
    """Return how the muscles are driven: by what is given."""
    kinds = [kind for kind in DRIVEN if any(name.startswith(f"load.{kind}") for name in given)]
    bend = bend_of(given, arm)
    if bend is not None:
        angles, planes = arc.to_polar(bend.reshape(-1, 2))
        return Muscles(kind="bend", values=tuple(np.stack([angles, planes], axis=-1).ravel()))
    if not kinds:
        return Muscles()
    count, name = muscles.count(arm), f"load.{kinds[0]}"
    values = list(given.get(name, (0.0,) * count))
    for k in range(count):
        values[k] = given.get(f"{name}.{k + 1}", values[k])
    return Muscles(kind=kinds[0], values=tuple(values))  # type: ignore[arg-type]

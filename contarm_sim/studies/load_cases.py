"""Static poses of an arm under one load after another, in numbers; a case without a pose says why."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import ContarmError, EquilibriumError, InputError, expect, one_line
from contarm_sim.inputs import read_text
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, load_from_dict
from contarm_sim.model.parameters import as_numbers
from contarm_sim.results.document import INLINE
from contarm_sim.statics.continuation import Method
from contarm_sim.statics.equilibria import equilibria
from contarm_sim.statics.equilibrium import Equilibrium, equilibrium
from contarm_sim.statics.extrapolation import Extrapolated, extrapolated
from contarm_sim.statics.leaning.touch import HeldObject, Touch
from contarm_sim.statics.places import Places


@dataclass(frozen=True)
class LoadCase:
    """An arm, with the gravity and payload of the case, a load, and where it was read, if in a file."""

    arm: Arm
    load: Load
    where: str | None = None


@dataclass(frozen=True, eq=False)
class Backbone:
    """Stations of the backbone, base frame: `centres` [m], shape (N + 1, 3), `frames`, shape (N + 1, 4, 4)."""

    centres: Array
    frames: Array


@dataclass(frozen=True)
class Trust:
    """Whether a pose is extrapolated, and how far the tip may be off [m]; NaN where nothing tells."""

    trusted: bool
    error_estimate: float


@dataclass(frozen=True, eq=False)
class PosesAt:
    """Poses at places `xi` along the backbone, 0 base to 1 tip, shape (K,): 4x4 frames, shape (K, 4, 4)."""

    xi: Array
    poses: Array


@dataclass(frozen=True, eq=False, repr=False)
class CaseAtRest(Shown):
    """A static pose in numbers, as in `Equilibrium`; base frame.

    Attributes:
        tip: position [m], shape (3,).
        transform: frame of the tip, shape (4, 4).
        backbone: its stations.
        muscle_lengths, muscle_tensions: [m] and [N], shape (M,).
        muscle_pressures: gauge pressures that these tensions need [Pa], shape (M,); inf where none does it.
        tip_compliance: [m/N, rad/N, m/(N m), rad/(N m)], shape (6, 6).
        residual, stable, smallest_eigenvalue, growth, held, iterations, seconds: how it was found and whether it lasts.
        beyond: what real muscles have not got, of force or pressure, in words; empty if they have.
        contacts, friction_range, held_objects: as of `Equilibrium`.
        trust: of an extrapolated pose, else None.
        places: where poses were asked for, else None.
    """

    tip: Array
    transform: Array
    backbone: Backbone
    muscle_lengths: Array
    muscle_tensions: Array
    muscle_pressures: Array
    tip_compliance: Array
    residual: float
    stable: bool
    smallest_eigenvalue: float
    growth: float
    held: bool | None
    beyond: str
    iterations: int
    seconds: float
    contacts: tuple[Touch, ...]
    friction_range: float | None
    held_objects: tuple[HeldObject, ...]
    trust: Trust | None = field(metadata=INLINE)
    places: PosesAt | None = field(metadata=INLINE)


@dataclass(frozen=True)
class CaseWithoutRest:
    """A case without an equilibrium that the load leads to; `error` says how far it got."""

    error: str
    stable: bool = False


def cases_at_rest(
    cases: Iterable[LoadCase], method: Method = "auto", extrapolate: bool = False, xi: Sequence[float] = ()
) -> tuple[CaseAtRest | CaseWithoutRest, ...]:
    """Return the static pose of every case.

    Args:
        method: as of `equilibrium`.
        extrapolate: improve poses by Richardson's extrapolation from half the links; with the method auto.
        xi: places along the backbone whose poses are interpolated, 0 base to 1 tip.

    Raises:
        InputError: a load that cannot be, a place off the arm, or another method beside `extrapolate`.
    """
    if extrapolate and method != "auto":
        raise InputError("method", f"{method} beside extrapolate", "extrapolate with the method auto")
    places = as_numbers(xi)
    if places is None or any(not 0 <= x <= 1 for x in places):
        raise InputError("xi", xi, "numbers from 0 (base) to 1 (tip)")
    cases = tuple(cases)
    for case in cases:
        expect("case", case, LoadCase)
        expect("arm", case.arm, Arm)
    leaning = any(case.arm.world.touchable for case in cases)
    several = len(cases) > 1 and not extrapolate and not leaning
    solved = _together(cases, method) if several else [_alone(case, method, extrapolate) for case in cases]
    return tuple(_told(case, found, places) for case, found in zip(cases, solved, strict=True))


def _alone(case: LoadCase, method: Method, extrapolate: bool) -> Equilibrium | ContarmError:
    arm, load = case.arm, case.load
    try:
        return extrapolated(arm, load)[0] if extrapolate else equilibrium(arm, load, method)
    except ContarmError as error:
        return error


def _together(cases: Sequence[LoadCase], method: Method) -> list[Equilibrium | ContarmError]:
    arms, loads = [case.arm for case in cases], [case.load for case in cases]
    every = equilibria(arms, loads, method=method, details=True)
    return [every.failed.get(index) or every.case(index) for index in range(len(every))]


def _told(case: LoadCase, found: Equilibrium | ContarmError, xi: Sequence[float]) -> CaseAtRest | CaseWithoutRest:
    if isinstance(found, EquilibriumError):
        return CaseWithoutRest(str(found))
    if isinstance(found, InputError):
        raise found.located(case.where) from None
    if isinstance(found, ContarmError):
        raise found
    arm = case.arm
    trust = Trust(found.trusted, found.error) if isinstance(found, Extrapolated) else None
    pressures = found.pressures_needed(arm)
    at = Places(arm, xi) if len(xi) else None
    return CaseAtRest(
        tip=found.tip,
        transform=found.frames[-1],
        backbone=Backbone(found.frames[:, :3, 3], found.frames),
        muscle_lengths=found.muscle_lengths,
        muscle_tensions=found.muscle_tensions,
        muscle_pressures=pressures,
        tip_compliance=found.tip_compliance,
        residual=found.residual,
        stable=found.stable,
        smallest_eigenvalue=found.smallest_eigenvalue,
        growth=found.growth,
        held=found.held,
        beyond=beyond(arm, found.muscle_tensions, pressures),
        iterations=found.iterations,
        seconds=found.seconds,
        contacts=found.contacts,
        friction_range=found.friction_range,
        held_objects=found.held_objects,
        trust=trust,
        places=PosesAt(at.xi, at.of(found.frames)) if at else None,
    )


def beyond(arm: Arm, tensions: Array, pressures: Array) -> str:
    """Say what real muscles have not got, of forces [N] or pressures [Pa], shape (M,); empty if they have."""
    ends = np.cumsum([group.routing.count for group in arm.groups])[:-1]
    for group, own, needed in zip(arm.groups, np.split(tensions, ends), np.split(pressures, ends), strict=False):
        tension, force = float(own.max()), group.law.blocked_force
        if tension > force:
            return f"a muscle pulls with {tension:.4g} N, more than its blocked force, {force:.0f} N"
        pressure, most = float(needed.max()), group.law.pressure_limits[1]
        if pressure > most * (1 + 1e-9):
            needs = f"{pressure / 1e3:.0f} kPa" if math.isfinite(pressure) else "more than any pressure"
            return f"a muscle needs {needs}, more than the {most / 1e3:.0f} kPa there are"
    return ""


def read_cases(file: str | Path, arm: Arm) -> tuple[LoadCase, ...]:
    """Read load cases from a JSON list; a case may give the arm another gravity and payload.

    Raises:
        InputError: not such a file; says which case is wrong.
    """
    allowed, name = "a JSON list of load cases", str(file)
    text = read_text(file, allowed)
    try:
        cases = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError("file", f"not JSON ({one_line(str(error), 80)})", allowed, name) from error
    if not isinstance(cases, list) or not cases:
        raise InputError("file", "no list, or an empty one", allowed, name)
    found = []
    for number, case in enumerate(cases, 1):
        where = f"{name}, case {number}"
        load, changes = load_from_dict(case, where)
        try:
            found.append(LoadCase(replace(arm, **changes), load, where))
        except InputError as error:
            raise error.located(where) from None
    return tuple(found)

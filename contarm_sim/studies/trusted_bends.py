"""How far an arm may bend before its tip leaves that of the constant-curvature arcs, by load and by bending plane."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import DivergenceError, EquilibriumError, PressureError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.results.document import HIDDEN, INLINE
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.studies.scenarios import UPRIGHT, under_loads, weight_over_stiffness

WITHIN = (0.1, 1.0, 5.0)
"""Tip errors that are asked about [% of length]."""

STEP = math.radians(5.0)
"""Bend angles that are tried on the way out [rad]; between two of them the place is searched for."""

SMALL = np.radians([0.0, 1.0, 2.0])
"""Bend angles before the first of these steps [rad]."""

CLOSE = math.radians(0.02)
"""To what largest bends are found [rad]."""

NO_REST = math.inf
"""Stands for the tip error of a pose that has no rest."""

WITHOUT_REST = (EquilibriumError, DivergenceError, PressureError)
"""Errors of poses that have no rest."""


@dataclass(frozen=True)
class LoadedArm:
    """An arm under one load.

    Attributes:
        load: its name.
        meaning: the same in words.
        arm: with this gravity and payload.
        weight_over_stiffness: (m + payload) g L^2/EI [-]; of several sections, L/EI is the sum of theirs.
    """

    load: str
    meaning: str
    arm: Arm = field(metadata=HIDDEN)
    weight_over_stiffness: float


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class TrustedBend:
    """The largest bends below which the tip error stays within a bound.

    Attributes:
        within_percent: the bound [% of length].
        bend_deg: by bending plane [deg], shape (P,); of several sections that of each of them. 0 where the straight arm
            is beyond already, `Trust.max_bend_deg` where no bend is.
        least_deg: the least of them.
        towards_deg: the plane of that [deg].
        everywhere: whether no bend is beyond in any plane.
        no_rest: why the arm has no pose at rest beyond the least bend, or its muscles do not hold one; None where it is
            the tip error that is beyond.
    """

    within_percent: float
    bend_deg: Array
    least_deg: float
    towards_deg: float
    everywhere: bool
    no_rest: str | None


@dataclass(frozen=True, eq=False)
class Trusted:
    """Tip error by bend under one load, and how far to bend.

    Attributes:
        under: the load.
        error_percent: tip error against the arcs [% of length], shape (A, P), by bend angle and plane; inf where the
            arm has no rest.
        bends: the largest bends, one for each bound.
        muscles_to_deg: bend that was tried up to which muscles have the tension and pressure in every plane [deg].
    """

    under: LoadedArm = field(metadata=INLINE)
    error_percent: Array
    bends: tuple[TrustedBend, ...]
    muscles_to_deg: float

    def within(self, percent: float) -> TrustedBend:
        """Return the largest bends within one of the bounds [% of length].

        Raises:
            StopIteration: it was not asked about.
        """
        return next(bend for bend in self.bends if bend.within_percent == percent)


def loaded_arms(arm: Arm) -> list[LoadedArm]:
    """Return an arm free, under gravity and with a payload; one without gravity of its own hanging and upright."""
    loads, own = under_loads(arm), any(arm.gravity)
    kg = f"{loads['payload'].payload:g} kg"
    named = {
        "free": "no gravity",
        "gravity": "its gravity" if own else "hanging",
        "payload": f"its gravity and {kg}" if own else f"hanging with {kg}",
    }
    if not own:
        loads["upright"] = replace(loads["gravity"], gravity=UPRIGHT)
        named["upright"] = "standing up"
    return [LoadedArm(load, named[load], each, weight_over_stiffness(each)) for load, each in loads.items()]


def posed(arm: Arm, angle: Array, plane: Array) -> Array:
    """Return bends [rad], shape (..., 2 S), in which every section has the same bend angle and plane [rad]."""
    return np.tile(arc.from_polar(angle, plane), len(arm.sections))


def rests(arm: Arm, angles: Array, plane: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return what `rests_at` does of bend angles, shape (A,), in a plane [rad]."""
    return rests_at(arm, posed(arm, angles, np.full(len(angles), plane)))


def rests_at(arm: Arm, bends: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return tip errors at rest against the arcs [% of length], and whether the muscles have what it takes, shape (T,).

    Of bends [rad], shape (T, 2 S). `NO_REST` where the arm has no rest.
    """
    try:
        found = poses_at_rest(arm, Reference.from_bends(bends, arm))
    except WITHOUT_REST:
        if len(bends) == 1:
            return np.array([NO_REST]), np.array([False])
        half = len(bends) // 2
        parts = [rests_at(arm, part) for part in (bends[:half], bends[half:])]
        return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])
    return 100 * found.tip_error / arm.length, have_enough(found)


def have_enough(found: Trajectory) -> NDArray[np.bool_]:
    """Tell of poses at rest, shape (T,), whether tensions and pressures are within what the muscles have."""
    arm = found.arm
    blocked = muscles.each(arm, lambda group: group.law.blocked_force)
    highest = muscles.each(arm, lambda group: group.law.pressure_limits[1])
    pressed = np.isfinite(highest)
    pressures = (found.pressure[:, pressed] <= highest[pressed]).all(axis=1)
    return np.asarray((found.muscle_tensions <= blocked).all(axis=1) & pressures, dtype=bool)


def tip_errors(arm: Arm, angles: Array, plane: float) -> Array:
    """Return tip errors [% of length], shape (A,), as `rests` does."""
    return rests(arm, angles, plane)[0]


def tip_error(arm: Arm, angle: float, plane: float) -> float:
    """Return the tip error [% of length] of one bend angle in a plane [rad], as `tip_errors`."""
    return float(tip_errors(arm, np.array([angle]), plane)[0])


def why_no_rest(arm: Arm, angle: float, plane: float) -> str | None:
    """Say why an arm has no pose at rest of a bend angle in a plane [rad]; None if it has one."""
    try:
        poses_at_rest(arm, Reference.from_bends(posed(arm, np.array([angle]), np.array([plane])), arm))
    except WITHOUT_REST as error:
        return str(error)
    return None


def trusted(under: LoadedArm, angles: Array, planes: Array, within: tuple[float, ...] = WITHIN) -> Trusted:
    """Return tip errors over bend angles, shape (A,), from 0, and planes [rad], shape (P,), and the largest bends."""
    arm = under.arm
    both = [rests(arm, angles, plane) for plane in planes]
    errors = np.stack([error for error, _ in both], axis=1)
    enough = np.stack([held for _, held in both], axis=1)

    def bend(bound: float, column: int) -> float:
        return first_beyond(lambda angle: tip_error(arm, angle, planes[column]), angles, errors[:, column], bound)

    bends = []
    for bound in within:
        found = rounded(np.degrees(np.array([bend(bound, column) for column in range(len(planes))], dtype=float)))
        worst = int(found.argmin())
        everywhere = bool((errors <= bound).all())
        least, plane = float(found[worst]), float(planes[worst])
        reason = None if everywhere else why_no_rest(arm, math.radians(least) + 2 * CLOSE, plane)
        bends.append(TrustedBend(bound, found, least, round(math.degrees(plane), 6), everywhere, reason))
    lost = np.where(enough.all(axis=0), len(angles), (~enough).argmax(axis=0)).min()  # the first that is not held
    held = 0.0 if lost == 0 else math.degrees(angles[lost - 1])
    return Trusted(under, errors, tuple(bends), round(held, 6))


def bend_within(found: Trajectory, percent: float) -> float | None:
    """Return the largest bend [rad] below which the tip error stays within a bound, from poses at rest over the dome.

    As `trusted` has it, with fewer simulations: it is searched for in the one plane that is the first to be beyond.
    0 where the straight arm is beyond already, the largest bend of the poses where none is. None for poses of several
    sections, of another controller than servos, or that are not angles by planes (`studies.scenarios.dome_grid`).

    Args:
        percent: the bound [% of length].
    """
    dome = _dome(found.arm, found.bend) if found.controller == "servo" else None
    if dome is None:
        return None
    angles, planes, order = dome
    return _first_over(found.arm, angles, planes, (100 * found.tip_error / found.arm.length)[order], percent)


def bends_within_of_lost(arm: Arm, bends: Array, percents: tuple[float, ...]) -> list[float | None]:
    """Return what `bend_within` does of an arm with servos that has no rest in some of the poses, for some bounds.

    Args:
        bends: of the poses [rad], shape (T, 2 S).
        percents: the bounds [% of length].
    """
    dome = _dome(arm, bends)
    if dome is None:
        return [None] * len(percents)
    angles, planes, order = dome
    errors = np.full(order.shape, NO_REST)
    for ring, row in enumerate(order):
        errors[ring] = rests_at(arm, bends[row])[0] if ring else tip_error(arm, 0.0, 0.0)
        if np.isinf(errors[ring]).any():  # what is farther out does not count
            break
    return [_first_over(arm, angles, planes, errors, percent) for percent in percents]


def _dome(arm: Arm, bends: Array) -> tuple[Array, Array, NDArray[np.intp]] | None:
    """Return bend angles (A,), planes (P,) [rad], and which of the bends has which, shape (A, P); None of no dome."""
    if len(arm.sections) > 1:
        return None
    angle, plane = (np.round(each, 9) for each in arc.to_polar(bends))
    angles, planes = np.unique(angle), np.unique(plane[angle > 0])
    if angles[0] != 0 or len(angle) != 1 + (len(angles) - 1) * len(planes):
        return None
    straight, bent = np.flatnonzero(angle == 0), np.lexsort((plane, angle))[1:]  # the straight pose is the first
    return angles, planes, np.vstack([np.full(len(planes), straight[0]), bent.reshape(-1, len(planes))])


def _first_over(arm: Arm, angles: Array, planes: Array, known: Array, percent: float) -> float:
    """Return the largest bend [rad] within a bound, of tip errors [% of length], shape (A, P).

    In the plane that is the first to be beyond; where several have no rest, in that of them in which it ends first.
    """
    beyond = ~(known <= percent)
    if not beyond.any():
        return float(angles[-1])
    ring = int(beyond.any(axis=1).argmax())
    if ring == 0:
        return 0.0
    least = math.inf
    for column in np.flatnonzero(known[ring] == known[ring].max()):
        error = partial(tip_error, arm, plane=float(planes[column]))
        if least == math.inf or not error(least) <= percent:
            least = min(least, first_beyond(error, angles, known[:, column], percent))
    return least


def rounded(degrees: Array) -> Array:
    """Return angles [deg] without the rounding of radians."""
    return np.asarray(np.round(degrees, 6), dtype=float)


def first_beyond(error: Callable[[float], float], angles: Array, known: Array, bound: float) -> float:
    """Return the bend angle [rad] up to which an error stays within a bound, the last one if it does all along.

    Args:
        error: of a bend angle.
        angles, known: bend angles from 0 and their errors, shape (A,).
    """
    beyond = np.flatnonzero(~(known <= bound))
    if len(beyond) == 0:
        return float(angles[-1])
    if beyond[0] == 0:
        return 0.0
    low, high = float(angles[beyond[0] - 1]), float(angles[beyond[0]])
    while high - low > CLOSE:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if error(middle) <= bound else (low, middle)
    return low

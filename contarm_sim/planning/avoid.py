"""Inverse kinematics that keeps the whole backbone clear of the objects of the world."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import BlockedError, InputError, UnreachableError, expect
from contarm_sim.kinematics import dome, inverse, sections
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.checks import as_choice, as_near, one_goal
from contarm_sim.kinematics.inverse.choices import Choice, penalty
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.targets import in_closed_form
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.planning import loose
from contarm_sim.planning.clearance import Clearance, Nearest, clearance_of
from contarm_sim.planning.search import Found, Search

MARGIN = 0.025
"""Clearance that is kept by default, as a share of the arm's length: see `default_margin`."""

_POINTS = 60  # samples of each branch of a family


@dataclass(frozen=True, repr=False)
class Avoiding(Shown):
    """A pose that reaches a target and keeps clear.

    Attributes:
        bends: of the sections [rad], shape (S, 2).
        miss: distance from the target to the tip [m].
        nearest: where the arm and an object are nearest, and the clearance there.
        margin: clearance that was asked for [m].
        looked: how many poses were looked at; 1 where the pose that would be chosen without objects is clear.
        solutions: how many there are, blocked ones too; -1 where they are a continuum.
    """

    bends: Array
    miss: float
    nearest: Nearest
    margin: float
    looked: int
    solutions: int

    @property
    def clearance(self) -> float:
        """Distance from the arm's surface to the nearest object [m]: a lower bound."""
        return self.nearest.clearance


def default_margin(arm: Arm) -> float:
    """Return the clearance that is kept by default [m]: 2.5 % of the arm's length.

    A simulated arm sags beside its arcs. Held by the controller `tip`, the backbones of the hanging presets did so by
    1 % of their length in half of 60 random poses, and by 2.7 % at most. By `servo` it is 3 to 5 %: ask for more.
    """
    return MARGIN * arm.length


def avoid(
    arm: Arm, target: Any, margin: float | None = None, direction: Any = None, rotation: Any = None,
    choose: Choice | None = None, near: Any = None, limits: Any = None,
) -> Avoiding:  # fmt: skip
    """Return bends whose tip is at a target, and whose whole backbone keeps clear of the objects of the arm's world.

    Of the poses that reach the target those are clear whose surface, a tube about the arcs as thick as what touches,
    is nowhere nearer to an object than the margin. Of these the choice takes one; the pose that it would take without
    objects, if that is clear. Families of one parameter (two sections and a position, three and a direction) are
    looked through from end to end. Of families of more parameters samples are looked at, and made clearer. What a
    `BlockedError` says of completeness holds for two sections and a position, and for three and a pose.

    Args:
        arm: with objects in its world; free ones are where they start.
        target: tip position in the base frame [m], shape (3,).
        margin: clearance to keep [m]; default `default_margin`.
        direction, rotation, choose, near: as of `kinematics.inverse.solve`, of one target.
        limits: largest bend angles [rad], as of `mechanics.shape.backbone`; default those of the muscles' lengths.

    Raises:
        InputError: an arm without objects, a margin below 0, a target in an object, or as `solve`.
        UnreachableError: no pose reaches the target.
        BlockedError: poses do, and none that was looked at is clear.
    """
    expect("arm", arm, Arm)
    clearance, margin = clearance_of(arm), checked_margin(arm, margin)
    backbone = clearance.backbone if limits is None else shape.backbone(arm, limits=limits)
    goal = one_goal(target, direction, rotation, arm.length)
    choose = as_choice(choose, near)
    near = None if near is None else np.asarray(as_near(near, backbone, ()))[0]
    found = inverse.solve(goal.position[0], backbone, direction, rotation, choose, near)
    check_point(clearance, goal.position[0])
    _check_reached(arm, goal, found, backbone)
    first = clearance.nearest(found.bends)
    if first.clearance >= margin:
        return Avoiding(found.bends, float(found.miss), first, margin, 1, int(found.solutions))

    search = Search(clearance, backbone, margin, goal, lambda bends: penalty(bends, backbone, choose, near))
    search.look(found.bends[None])
    _check_ends(clearance, goal.position[0], margin)
    best = _searched(search, found, direction, rotation)
    if best.bends is None:
        raise blocked(goal.position[0], best, margin, arm, backbone.limits)
    miss = float(np.linalg.norm(sections.position(best.bends, backbone) - goal.position[0]))
    return Avoiding(best.bends, miss, best.nearest, margin, best.looked, int(found.solutions))


def _searched(search: Search, found: inverse.Inverse, direction: Any, rotation: Any) -> Found:
    """Return what is found of the other solutions."""
    goal, backbone = search.goal, search.backbone
    if len(backbone) == 1 or found.solutions == 1:
        return search.ended(None, True)
    if 2 * len(backbone) - goal.conditions > 1 and found.solutions < 0:
        return loose.among(search, found.bends[None])
    curves = inverse.solve_all(goal.position[0], backbone, direction, rotation, _POINTS)
    if not curves:
        return search.ended(None, False)
    every = (len(backbone) == 2 and goal.conditions == 3) or (rotation is not None and in_closed_form(goal, backbone))
    best = search.along(curves)
    return best if every else replace(best, whole=False)  # random starts led to the curves


def solutions(
    arm: Arm,
    target: Any,
    margin: float | None = None,
    direction: Any = None,
    rotation: Any = None,
    points: int = _POINTS,
) -> list[tuple[Array, Array]]:
    """Return the curves, or samples, of poses that reach a target, blocked ones too, and how clear each pose is.

    Bends [rad], shape (K, S, 2), and clearances at places along the arm [m], shape (K,); `points` as of `solve_all`.

    Raises:
        InputError: as `avoid`.
    """
    clearance, margin = clearance_of(arm), checked_margin(arm, margin)
    curves = inverse.solve_all(target, clearance.backbone, direction, rotation, points)
    return [(curve, clearance.rough(curve, margin)) for curve in curves]


def checked_margin(arm: Arm, margin: Any) -> float:
    """Return a margin [m].

    Raises:
        InputError: no number of 0 or more.
    """
    if margin is None:
        return default_margin(arm)
    try:
        value = float(margin)
    except (TypeError, ValueError):
        value = math.nan
    if not 0 <= value < math.inf:
        raise InputError("margin", margin, "a clearance of 0 or more [m]")
    return value


def _check_reached(arm: Arm, goal: Goals, found: inverse.Inverse, backbone: Backbone) -> None:
    """Refuse a target that no pose reaches.

    Raises:
        UnreachableError: says what is nearest to it.
    """
    if not found.reachable:
        raise UnreachableError(
            goal.position[0], float(found.miss), sections.position(found.bends, backbone), dome.TOLERANCE * arm.length,
            0, angle=float(found.angle_miss), dome=len(backbone) == 1,
            limits=backbone.limits[1:] and backbone.limits,
        )  # fmt: skip


def check_point(clearance: Clearance, target: Array, where: str | None = None) -> None:
    """Refuse a target inside of an object.

    Raises:
        InputError: says of which, and how deep.
    """
    (distance,), (number,) = clearance.of_points(target[None])
    if distance < 0:
        name = clearance.names[number]
        given = f"({', '.join(f'{x:.6g}' for x in target)}) m, {-1e3 * distance:.3g} mm inside of {name!r}"
        raise InputError("target", given, "a place outside of the objects", where)


def _check_ends(clearance: Clearance, target: Array, margin: float) -> None:
    """Refuse a target, or an object at the base, that leaves no pose clear.

    Raises:
        BlockedError: says which.
    """
    for what, point, radius in (
        ("base", np.zeros(3), clearance.tube.radius[0]),
        ("target", target, clearance.tube.radius[-1]),
    ):
        (distance,), (number,) = clearance.of_points(point[None])
        if distance - radius < margin:
            name = clearance.names[number]
            raise BlockedError(
                f"the {what} is {1e3 * distance:.4g} mm from {name!r}, and the arm is {1e3 * radius:.4g} mm thick "
                f"about its backbone, so that no pose is clear of it by {1e3 * margin:.4g} mm",
                float(distance - radius), margin, name,
            )  # fmt: skip


def blocked(target: Array, found: Found, margin: float, arm: Arm, limits: tuple[float, ...]) -> BlockedError:
    """Return the error that says that no pose is clear, and how far that is known."""
    nearest, at = found.nearest, f"({', '.join(f'{x:.6g}' for x in target)}) m"
    if found.looked == 1:
        said, known = f"the one pose that reaches {at} is not", ""
    elif found.whole:
        said, known = f"none of the poses that reach {at} is", f" ({found.looked} of a family, from end to end)"
    else:
        said, known = f"none of the {found.looked} poses that were tried and reach {at} is", "; there may be others"
    bends = f"bends up to {', '.join(f'{math.degrees(x):.4g}' for x in limits)} deg"
    return BlockedError(
        f"{said} clear of the objects by {1e3 * margin:.4g} mm with {bends}: the clearest is "
        f"{1e3 * nearest.clearance:.4g} mm from {nearest.object!r} at {1e3 * nearest.xi * arm.length:.4g} mm along the "
        f"arm{known}",
        nearest.clearance, margin, nearest.object,
    )  # fmt: skip

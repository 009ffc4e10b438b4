"""The front door of inverse kinematics: targets of tips to bends, by closed forms where there are some.

    sections    position          position, direction    pose
    1           nearest tip of the dome, whatever turn is asked for
    2           closed form       closed form            least squares
    3           least squares     least squares*         closed form
    4 to 6      least squares     least squares          least squares

Where least squares find nothing, * goes to the closed form of all rolls, which is slower. What a closed form does not
take (three sections with connectors between them) goes to least squares alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.dome import bend_from_tip
from contarm_sim.kinematics.inverse.checks import as_goals, as_near, check_choice, one_goal
from contarm_sim.kinematics.inverse.choices import Choice
from contarm_sim.kinematics.inverse.general.choosing import solve_general
from contarm_sim.kinematics.inverse.general.least_squares import STRICT, descend
from contarm_sim.kinematics.inverse.general.solutions import samples
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import clamped
from contarm_sim.kinematics.inverse.result import Inverse
from contarm_sim.kinematics.inverse.three.choosing import solve_direction, solve_pose
from contarm_sim.kinematics.inverse.three.solutions import all_poses
from contarm_sim.kinematics.inverse.two.choosing import solve_two
from contarm_sim.kinematics.inverse.two.solutions import family


def solve(
    position: Any,
    backbone: Backbone,
    direction: Any = None,
    rotation: Any = None,
    choose: Choice = "least-bend",
    near: Any = None,
) -> Inverse:
    """Return bends whose tips are at targets, vectorised over leading axes, of 1 to 6 sections.

    A target that cannot be reached gets the nearest bends known, their miss, and `reachable` False.

    Args:
        position: of the tips in the base frame [m], shape (..., 3).
        direction: that the z axes of the tips are to have, shape (..., 3), of any length but 0; or None.
        rotation: of the tips in the base frame, shape (..., 3, 3), or None; see `rotation_from_quaternion`.
        choose: which of many solutions: `least-bend` (least sum of bend angles), `least-largest` (least largest bend
            angle), `farthest` (from the limits), `nearest` (to `near`).
        near: bends [rad], shape (..., S, 2), for `nearest`.

    Raises:
        InputError: targets that are none, an unknown choice, or `nearest` without `near`.
    """
    check_choice(choose, near)
    goals, shape = as_goals(position, direction, rotation, backbone.length)
    return _solve(goals, backbone, choose, as_near(near, backbone, shape)).shaped(shape)


def solve_all(
    position: Any, backbone: Backbone, direction: Any = None, rotation: Any = None, points: int = 60
) -> list[Array]:
    """Return all solutions of one target known, as a list of bends [rad], each of shape (K, S, 2); [] for none.

    Isolated solutions come one by one (K = 1), in order of their sums of bend angles. Of a family of one parameter,
    each piece is a curve of about `points` solutions in order. Families of more parameters are one item, `points`
    of them in order of their sums of bend angles.

    Raises:
        InputError: targets that are none, or several.
    """
    goal = one_goal(position, direction, rotation, backbone.length)
    if len(backbone) == 2 and goal.conditions == 3:
        return list(family(goal.position[0], backbone).curve(points))
    if in_closed_form(goal, backbone) and goal.rotation is not None:
        bends, found = all_poses(goal.position[0], goal.rotation[0], backbone)
        return [bends[k : k + 1] for k in range(int(found))]
    return samples(goal, backbone, points)


def in_closed_form(goals: Goals, backbone: Backbone) -> bool:
    """Return whether three sections, and what is asked of them, have a closed form."""
    return len(backbone) == 3 and goals.conditions > 3 and not any(backbone.connectors[:-1])


def _solve(goals: Goals, backbone: Backbone, choose: Choice, near: Array | None) -> Inverse:
    if len(backbone) == 1:
        return _solve_one(goals, backbone)
    if len(backbone) == 2 and goals.rotation is None:
        return solve_two(goals, backbone, choose, near)
    if goals.rotation is not None and in_closed_form(goals, backbone):
        return solve_pose(goals, backbone, choose, near)
    answer = solve_general(goals, backbone, choose, near)
    rows = np.flatnonzero(~answer.reachable)
    if len(rows) and in_closed_form(goals, backbone):
        own = None if near is None else near[rows]
        answer = answer.replaced(rows, solve_direction(goals.take(rows), backbone, choose, own))
    return answer


def _solve_one(goals: Goals, backbone: Backbone) -> Inverse:
    """Return the nearest tip of the dome, and how far the turn asked for is from that tip's."""
    bends = clamped(bend_from_tip(goals.position, backbone.length, "nearest").bend[:, None], backbone)
    if backbone.links is not None or any(backbone.connectors):
        bends = clamped(descend(Goals(goals.position), backbone, bends, limited=STRICT), backbone)
    return goals.answered(bends, backbone, 1)

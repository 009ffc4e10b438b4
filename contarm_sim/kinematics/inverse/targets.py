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

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone, as_bends
from contarm_sim.kinematics.dome import bend_from_tip
from contarm_sim.kinematics.inverse.choices import Choice, check_choice
from contarm_sim.kinematics.inverse.families import samples
from contarm_sim.kinematics.inverse.general import solve_general
from contarm_sim.kinematics.inverse.goals import Goals, as_goals
from contarm_sim.kinematics.inverse.least_squares import clamped, descend, reached
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH, TOLERANCE, Inverse


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
    reference = None if near is None else _near(near, backbone, shape)
    answer = _solve(goals, backbone, choose, reference)
    return Inverse(
        answer.bends.reshape(*shape, len(backbone), 2),
        answer.miss.reshape(shape),
        answer.angle_miss.reshape(shape),
        answer.reachable.reshape(shape),
        answer.solutions.reshape(shape),
    )


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
    goals, shape = as_goals(position, direction, rotation, backbone.length)
    if shape:
        raise InputError("position", f"of shape {(*shape, 3)}", "one target, shape (3,)")
    free = 2 * len(backbone) - goals.conditions
    if len(backbone) == 2 and free == 1:
        from contarm_sim.kinematics.inverse import two_sections

        return list(two_sections.family(goals.position[0], backbone).curve(points))
    if len(backbone) == 3 and goals.rotation is not None and not any(backbone.connectors[:-1]):
        from contarm_sim.kinematics.inverse import three_sections

        bends, found = three_sections.all_poses(goals.position[0], goals.rotation[0], backbone)
        return [bends[k : k + 1] for k in range(int(found))]
    return samples(goals, backbone, points)


def _solve(goals: Goals, backbone: Backbone, choose: Choice, near: Array | None) -> Inverse:
    size, count = len(backbone), len(goals)
    if size == 1:
        return _solve_one(goals, backbone)
    if size == 2 and goals.rotation is None:
        from contarm_sim.kinematics.inverse import two_sections

        if goals.direction is None:
            return two_sections.solve_position(goals.position, backbone, choose=choose, near=near)
        return two_sections.solve_direction(goals.position, goals.direction, backbone)
    if size == 3 and goals.conditions > 3 and not any(backbone.connectors[:-1]) and count:
        from contarm_sim.kinematics.inverse import three_sections

        if goals.rotation is not None:
            return three_sections.solve_pose(goals.position, goals.rotation, backbone, choose=choose, near=near)
        answer = solve_general(goals, backbone, choose, near)
        rows = np.flatnonzero(~answer.reachable)
        if len(rows):
            own, left = None if near is None else near[rows], goals.take(rows)
            other = three_sections.solve_direction(left.position, left.direction, backbone, choose=choose, near=own)
            for name in ("bends", "miss", "angle_miss", "reachable", "solutions"):
                getattr(answer, name)[rows] = getattr(other, name)
        return answer
    return solve_general(goals, backbone, choose, near)


def _solve_one(goals: Goals, backbone: Backbone) -> Inverse:
    """Return the nearest tip of the dome, and how far the turn asked for is from that tip's."""
    position = Goals(goals.position)
    bends = bend_from_tip(goals.position, backbone.length, "nearest").bend[:, None]
    if backbone.links is not None or any(backbone.connectors):
        bends = descend(position, backbone, clamped(bends, backbone), limited=100.0)
    bends = clamped(bends, backbone)
    miss, angle = reached(goals, backbone, bends)
    within = np.maximum(miss, ANGLE_LENGTH * backbone.length * angle) <= TOLERANCE * backbone.length
    return Inverse(bends, miss, angle, within, within.astype(np.intp))


def _near(near: Any, backbone: Backbone, shape: tuple[int, ...]) -> Array:
    """Return the bends that solutions are to be nearest to, shape (n, S, 2).

    Raises:
        InputError: no bends, or not as many as targets.
    """
    size = len(backbone)
    bends = as_bends(near, backbone)
    try:
        return np.broadcast_to(bends, (*shape, size, 2)).reshape(-1, size, 2)
    except ValueError:
        raise InputError("near", f"of shape {bends.shape}", f"shape {(*shape, size, 2)}, or one for all") from None

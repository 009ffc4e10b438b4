"""Inverse kinematics of three sections: all solutions of a pose, or one chosen; position and direction of the tip."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import sections
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.kinematics.backbone import Backbone, as_bends
from contarm_sim.kinematics.inverse.pose_nearest import nearest
from contarm_sim.kinematics.inverse.pose_search import Index, one_arc
from contarm_sim.kinematics.inverse.pose_solutions import polished, solutions
from contarm_sim.kinematics.inverse.pose_targets import check_sections, common, targets
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH, TOLERANCE, Inverse
from contarm_sim.kinematics.inverse.roll import Rank, best_rolls, rotation_to

CHOICES = ("least-bend", "least-largest", "farthest", "nearest")
"""Which solution: of the least sum of bend angles, of the least largest one, farthest from the limits, or nearest to a
given pose."""

_FAR = 1e4  # lengths of the arm


def all_poses(position: Any, rotation: Any, backbone: Backbone) -> tuple[Array, Index]:
    """Return all bends within the limits that reach poses, by total bend, and how many there are.

    Args:
        position: of the tip [m], shape (..., 3).
        rotation: of the tip, shape (..., 3, 3).
        backbone: three sections; the only connector is the tool at the tip.

    Returns:
        Bends [rad], shape (..., K, 3, 2), NaN beyond their number, and their number, shape (...). Of the continuum of
        solutions of a pose that one arc reaches, those in its plane.

    Raises:
        InputError: not three sections, a connector between sections, numbers that are not finite, or no rotation.
    """
    position, rotation, shape = targets(position, rotation, backbone)
    bends, count = solutions(_without_tool(position, rotation[:, :, 2], backbone), rotation, _bare(backbone))
    return bends.reshape(*shape, *bends.shape[1:]), count.reshape(shape)


def solve_pose(position: Any, rotation: Any, backbone: Backbone, choose: str = "least-bend",
               near: Any = None) -> Inverse:  # fmt: skip
    """Return one solution of each pose; where there is none, the nearest pose that damped least squares finds.

    Args:
        position: of the tip [m], shape (..., 3).
        rotation: of the tip, shape (..., 3, 3).
        backbone: three sections; the only connector is the tool at the tip.
        choose: one of `CHOICES`.
        near: bends [rad] that "nearest" compares with, shape (..., 3, 2).

    Returns:
        The choice; `solutions` is -1 where one arc reaches the pose and a continuum of bends with it.

    Raises:
        InputError: as `all_poses`, or a choice that is none, or one of the nearest to nothing.
    """
    position, rotation, shape = targets(position, rotation, backbone)
    _, rank = _rank(choose, near, backbone, shape)
    bare, end = _bare(backbone), _without_tool(position, rotation[:, :, 2], backbone)
    found, count = solutions(end, rotation, bare)
    ranks, (row, place) = np.full(found.shape[:2], np.inf), np.nonzero(np.isfinite(found[..., 0, 0]))
    ranks[row, place] = rank(found[row, place], row)
    bends = found[np.arange(len(found)), np.argmin(ranks, axis=1)]
    none = np.flatnonzero(count == 0)
    if none.size:
        bends[none] = polished(end[none], rotation[none], nearest(end[none], rotation[none], bare), bare)
    reached = sections.transform(bends, backbone, check=False)
    off = np.linalg.norm(reached[:, :3, :3] - rotation, axis=(-1, -2))
    angle = 2 * np.arcsin(np.minimum(off / np.sqrt(8), 1.0))
    straight = np.linalg.norm(end, axis=-1) > bare.length * (1 - 1e-12)
    count = np.where(one_arc(end, rotation, bare) & ~straight & (count > 0), -1, count)
    return _result(bends, reached, position, angle, count, backbone, shape)


def solve_direction(position: Any, direction: Any, backbone: Backbone, choose: str = "least-bend",
                    near: Any = None) -> Inverse:  # fmt: skip
    """Return one solution of each position and direction of the tip, of the continuum that its roll leaves.

    Rolls are sampled, and the best is made better between its neighbours; where none is found, as `solve_pose`.

    Args:
        position: of the tip [m], shape (..., 3).
        direction: of the tip's axis, of any length but 0, shape (..., 3).
        backbone: three sections; the only connector is the tool at the tip.
        choose: one of `CHOICES`.
        near: bends [rad] that "nearest" compares with, shape (..., 3, 2).

    Returns:
        The choice; `solutions` is -1, or 0 where there is none.

    Raises:
        InputError: as `solve_pose`, or a direction of length 0.
    """
    check_sections(backbone)
    position, direction = as_vectors(position, 3, "position"), as_vectors(direction, 3, "direction")
    shape = common(position.shape[:-1], direction.shape[:-1], "direction")
    size = np.abs(direction).max(axis=-1, keepdims=True)
    if not np.all(size > 0):
        raise InputError("direction", "0 long", "vectors of any other length")
    direction = direction / size
    direction = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    position = np.broadcast_to(position, (*shape, 3)).reshape(-1, 3)
    rotation = rotation_to(np.broadcast_to(direction, (*shape, 3)).reshape(-1, 3))
    to, rank = _rank(choose, near, backbone, shape)
    bare, end = _bare(backbone), _without_tool(position, rotation[:, :, 2], backbone)
    bends = best_rolls(end, rotation, bare, rank, to)
    reached = sections.transform(bends, backbone, check=False)
    off = np.linalg.norm(reached[:, :3, 2] - rotation[:, :, 2], axis=-1)
    angle = 2 * np.arcsin(np.minimum(0.5 * off, 1.0))
    out = _result(bends, reached, position, angle, np.zeros(len(bends), dtype=np.intp), backbone, shape)
    return replace(out, solutions=np.where(out.reachable, -1, 0))


def _rank(choose: str, near: Any, backbone: Backbone, shape: tuple[int, ...]) -> tuple[Array | None, Rank]:
    """Return the bends that "nearest" compares with, shape (n, 3, 2), and what ranks bends, the least first."""
    if choose not in CHOICES:
        raise InputError("choose", choose, ", ".join(CHOICES))
    limits = np.asarray(backbone.limits)
    if choose == "nearest":
        if near is None:
            raise InputError("near", None, "bends to which the nearest solution is sought")
        given = as_bends(near, backbone)
        common(shape, given.shape[:-2], "near", shape)
        to = np.broadcast_to(given, (*shape, 3, 2)).reshape(-1, 3, 2)
        return to, lambda bends, rows: np.sum((bends - to[rows]) ** 2, axis=(-1, -2))
    if choose == "least-bend":
        return None, lambda bends, rows: np.hypot(bends[..., 0], bends[..., 1]).sum(axis=-1)
    off = limits if choose == "farthest" else np.zeros(3)
    return None, lambda bends, rows: (np.hypot(bends[..., 0], bends[..., 1]) - off).max(axis=-1)


def _result(bends: Array, reached: Array, position: Array, angle: Array, count: Index, backbone: Backbone,
            shape: tuple[int, ...]) -> Inverse:  # fmt: skip
    x, y, z = (reached[:, :3, 3] - position).T
    miss = np.hypot(np.hypot(x, y), z)
    most = TOLERANCE * backbone.length
    reachable = (miss <= most) & (angle * ANGLE_LENGTH * backbone.length <= most)
    count = np.where(reachable & (count == 0), 1, count)  # found by least squares
    return Inverse(
        bends.reshape(*shape, 3, 2), miss.reshape(shape), angle.reshape(shape), reachable.reshape(shape),
        count.reshape(shape),
    )  # fmt: skip


def _bare(backbone: Backbone) -> Backbone:
    return replace(backbone, connectors=(0.0,))


def _without_tool(position: Array, axis: Array, backbone: Backbone) -> Array:
    """Return where section 3 must end [m]; what is very far off is brought closer: its square must be a number."""
    far = np.abs(position).max(axis=-1, keepdims=True) / (_FAR * backbone.length)
    return np.asarray(position / np.maximum(far, 1.0) - backbone.connectors[-1] * axis)

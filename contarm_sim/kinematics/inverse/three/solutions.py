"""All solutions of poses of three sections: starts, Newton's method, and what it takes to lose none.

Where the Jacobian is nearly singular, solutions come in pairs, and both starts may run into one of the two, or one may
go unseen: each is sought from the other, beyond the fold between them, where the second derivative along the null
vector says.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.checks import as_goals, check_sections
from contarm_sim.kinematics.inverse.choices import distinct
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import angles_of, excess
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.kinematics.inverse.three.nearly_straight import NEAR, nearly_straight
from contarm_sim.kinematics.inverse.three.newton import SOLVED, refined
from contarm_sim.kinematics.inverse.three.search import one_arc, starts

NODES = 96
"""Places along each curve of first chords."""

_WEAK = 0.012  # singular value of the Jacobian over the length, sections being alike, from which a fold is near

_AT_ONCE = 48  # rows of a search: what it holds at a time stays in the processor's cache
_BLOCK = 2048
_OVER = 1e-12  # by how much rounding may carry a bend over its limit [rad]


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
    check_sections(backbone, 3)
    goals, shape = as_goals(position, None, rotation, backbone.length)
    bends, count = all_solutions(*without_tool(goals, backbone))
    return bends.reshape(*shape, *bends.shape[1:]), count.reshape(shape)


def without_tool(goals: Goals, backbone: Backbone) -> tuple[Goals, Backbone]:
    """Return where section 3 must end, and the arm without its tool."""
    assert goals.rotation is not None
    end = goals.position - backbone.connectors[-1] * goals.rotation[:, :, 2]
    return Goals(end, None, goals.rotation), replace(backbone, connectors=(0.0,))


def all_solutions(goals: Goals, backbone: Backbone, nodes: int = NODES,
                  more_nodes: int = 10 * NODES) -> tuple[Array, Index]:  # fmt: skip
    """Return all bends within the limits [rad], shape (n, K, 3, 2), by total bend, NaN beyond their number, shape (n,).

    Args:
        goals: poses.
        backbone: three sections, no connectors.
        nodes: places along each curve of first chords.
        more_nodes: the same where those find nothing; 0: leave it at that.
    """
    parts = [
        _block(goals.take(slice(start, start + _BLOCK)), backbone, nodes, more_nodes)
        for start in range(0, len(goals), _BLOCK)
    ]
    most = max((bends.shape[1] for bends, _ in parts), default=1)
    out = np.full((len(goals), most, 3, 2), np.nan)
    for number, (bends, _) in enumerate(parts):
        out[number * _BLOCK : (number + 1) * _BLOCK, : bends.shape[1]] = bends
    return out, np.concatenate([np.zeros(0, dtype=np.intp), *(count for _, count in parts)])


def _block(goals: Goals, backbone: Backbone, nodes: int, more_nodes: int) -> tuple[Array, Index]:
    reach = backbone.length * (1 + 1e-12)
    within = np.flatnonzero(np.sum(goals.position * goals.position, axis=-1) <= reach * reach)
    rows, bends = _found(goals.take(within), backbone, nodes)
    rows = within[rows]
    packed, count = _within(rows, bends, backbone, len(goals))
    none = within[count[within] == 0]
    if none.size and more_nodes:
        again, more = _found(goals.take(none), backbone, more_nodes)
        rows, bends = np.concatenate([rows, none[again]]), np.concatenate([bends, more])
        packed, count = _within(rows, bends, backbone, len(goals))
    return packed, count


def _found(goals: Goals, backbone: Backbone, nodes: int) -> tuple[Index, Array]:
    """Return rows and bends of solutions, each once or more often, whatever the limits."""
    if not len(goals):
        return np.zeros(0, dtype=np.intp), np.zeros((0, 3, 2))
    position, rotation = goals.position, goals.rotation
    assert rotation is not None
    step = max(1, _AT_ONCE * NODES // nodes)
    seen: list[tuple[Index, Array]] = []
    for start in range(0, len(position), step):
        row, bend = starts(position[start : start + step], rotation[start : start + step], backbone, nodes)
        seen.append((row + start, bend))
    near = np.flatnonzero(np.sum(position * position, axis=-1) > ((1 - NEAR) * backbone.length) ** 2)
    if near.size:
        seen += [(near, bend) for bend in nearly_straight(position[near], rotation[near], backbone)]
    rows, bends = (np.concatenate(each) for each in zip(*seen, strict=True))
    rows, bends, J = _solved(goals, rows, bends, backbone)
    paired = _nearly_singular(J, backbone)
    if paired.size:
        near = rows[paired]
        more, others, _ = _solved(goals, near, _beyond_fold(goals.take(near), bends[paired], J[paired], backbone),
                                  backbone)  # fmt: skip
        rows, bends = np.concatenate([rows, more]), np.concatenate([bends, others])
    return rows, bends


def _solved(goals: Goals, rows: Index, given: Array, backbone: Backbone) -> tuple[Index, Array, Array]:
    """Return rows, solutions and Jacobians of those starts that lead to a solution."""
    bends, miss, J = refined(goals.take(rows), given, backbone)
    assert goals.rotation is not None
    arc = np.flatnonzero(one_arc(goals.position, goals.rotation, backbone)[rows])
    if arc.size:  # rounding over a singular value of nothing would carry it along the continuum
        bends[arc], miss[arc], J[arc] = refined(goals.take(rows[arc]), given[arc], backbone, 1e-9)
    solved = miss <= SOLVED
    return rows[solved], bends[solved], J[solved]


def _nearly_singular(J: Array, backbone: Backbone) -> Index:
    """Return which solutions have a fold nearby, by their Jacobians."""
    # The norm of the inverse is one over the least singular value, nearly; where that is rounding, a continuum solves.
    proper = np.linalg.det(J) != 0
    inverse = np.linalg.inv(np.where(proper[:, None, None], J, np.eye(6)))
    size = np.sqrt(np.sum(inverse * inverse, axis=(-1, -2)))
    weak = 3 * _WEAK * min(backbone.lengths) / backbone.length
    return np.flatnonzero(proper & (size > 1 / weak) & (size < 1e9))


def _beyond_fold(goals: Goals, bends: Array, J: Array, backbone: Backbone) -> Array:
    """Return starts for the solutions that nearly singular ones are paired with."""
    step = 1e-4
    left, least, right = np.linalg.svd(J)
    u, least, along = left[..., -1], least[:, -1], right[:, -1]
    _, beside = goals.terms(bends + step * along.reshape(-1, 3, 2), backbone)
    curved = np.einsum("ni,nij,nj->n", u, beside - J, along) / step
    far = np.clip(-2 * least / np.where(curved == 0, 1.0, curved), -1.0, 1.0)
    return np.asarray(bends + far[:, None, None] * along.reshape(-1, 3, 2))


def _within(rows: Index, bends: Array, backbone: Backbone, count: int) -> tuple[Array, Index]:
    """Return the distinct solutions within the limits, by total bend, and how many each target has."""
    limits = np.asarray(backbone.limits)
    inside = excess(bends, backbone) <= _OVER
    rows, bends = rows[inside], bends[inside]
    angle = angles_of(bends)
    scale = np.minimum(1.0, np.divide(limits, angle, out=np.ones_like(angle), where=angle > limits))
    # A scaled bend may round up again: the next number below does not.
    scale = np.where(angle * scale > limits, np.nextafter(scale, 0), scale)
    bends = np.where((angle > limits)[..., None], bends * np.nextafter(scale, 0)[..., None], bends)
    order = np.lexsort((angle.sum(axis=-1), rows))
    rows, bends = rows[order], bends[order]
    number = np.bincount(rows, minlength=count)
    place = np.arange(len(rows)) - (np.cumsum(number) - number)[rows]
    packed = np.full((count, max(1, int(number.max(initial=0))), 3, 2), np.nan)
    packed[rows, place] = bends
    known = distinct(packed, np.arange(packed.shape[1]) < number[:, None])
    number = known.sum(axis=-1)
    first = np.argsort(~known, axis=-1, kind="stable")
    packed = np.where(known[..., None, None], packed, np.nan)
    packed = np.take_along_axis(packed, first[..., None, None], axis=1)
    return packed[:, : max(1, int(number.max(initial=0)))], number

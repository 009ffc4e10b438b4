"""All solutions of poses of three sections: starts, Newton's method, and what it takes to lose none.

Where the Jacobian is nearly singular, solutions come in pairs, and both starts may run into one of the two, or one may
go unseen: each is sought from the other, beyond the fold between them, where the second derivative along the null
vector says.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.nearly_straight import NEAR, nearly_straight
from contarm_sim.kinematics.inverse.pose_newton import SOLVED, misses, newton
from contarm_sim.kinematics.inverse.pose_search import Index, one_arc, starts

NODES = 96
"""Places along each curve of first chords."""

SAME = 1e-6
"""Bends that differ by less are one solution [rad]."""

_WEAK = 0.012  # singular value of the Jacobian over the length, sections being alike, from which a fold is near

_AT_ONCE = 48  # rows of a search: what it holds at a time stays in the processor's cache
_BLOCK = 2048
_OVER = 1e-12  # by how much rounding may carry a bend over its limit [rad]


def solutions(position: Array, rotation: Array, backbone: Backbone, nodes: int = NODES,
              more_nodes: int = 10 * NODES) -> tuple[Array, Index]:  # fmt: skip
    """Return all bends within the limits [rad], shape (n, K, 3, 2), by total bend, NaN beyond their number, shape (n,).

    Args:
        position: of the end of section 3 [m], shape (n, 3).
        rotation: of the end, shape (n, 3, 3).
        backbone: three sections, no connectors.
        nodes: places along each curve of first chords.
        more_nodes: the same where those find nothing; 0: leave it at that.
    """
    parts = [
        _block(position[start : start + _BLOCK], rotation[start : start + _BLOCK], backbone, nodes, more_nodes)
        for start in range(0, len(position), _BLOCK)
    ]
    most = max((bends.shape[1] for bends, _ in parts), default=1)
    out = np.full((len(position), most, 3, 2), np.nan)
    for number, (bends, _) in enumerate(parts):
        out[number * _BLOCK : (number + 1) * _BLOCK, : bends.shape[1]] = bends
    return out, np.concatenate([np.zeros(0, dtype=np.intp), *(count for _, count in parts)])


def polished(position: Array, rotation: Array, bends: Array, backbone: Backbone) -> Array:
    """Return solutions next to bends [rad], shape (n, 3, 2), or the bends given where none within the limits is."""
    better, miss, _ = newton(position, rotation, bends, backbone)
    solved = (miss <= SOLVED) & (np.hypot(better[..., 0], better[..., 1]) <= backbone.limits).all(axis=-1)
    return np.where(solved[:, None, None], better, bends)


def _block(position: Array, rotation: Array, backbone: Backbone, nodes: int,
           more_nodes: int) -> tuple[Array, Index]:  # fmt: skip
    reach = backbone.length * (1 + 1e-12)
    within = np.flatnonzero(np.sum(position * position, axis=-1) <= reach * reach)
    rows, bends = _found(position[within], rotation[within], backbone, nodes)
    rows = within[rows]
    packed, count = _within(rows, bends, backbone, len(position))
    none = within[count[within] == 0]
    if none.size and more_nodes:
        again, more = _found(position[none], rotation[none], backbone, more_nodes)
        rows, bends = np.concatenate([rows, none[again]]), np.concatenate([bends, more])
        packed, count = _within(rows, bends, backbone, len(position))
    return packed, count


def _found(position: Array, rotation: Array, backbone: Backbone, nodes: int) -> tuple[Index, Array]:
    """Return rows and bends of solutions, each once or more often, whatever the limits."""
    if not len(position):
        return np.zeros(0, dtype=np.intp), np.zeros((0, 3, 2))
    step = max(1, _AT_ONCE * NODES // nodes)
    seen: list[tuple[Index, Array]] = []
    for start in range(0, len(position), step):
        row, bend = starts(position[start : start + step], rotation[start : start + step], backbone, nodes)
        seen.append((row + start, bend))
    near = np.flatnonzero(np.sum(position * position, axis=-1) > ((1 - NEAR) * backbone.length) ** 2)
    if near.size:
        seen += [(near, bend) for bend in nearly_straight(position[near], rotation[near], backbone)]
    rows, bends = (np.concatenate(each) for each in zip(*seen, strict=True))
    rows, bends, J = _solved(position, rotation, rows, bends, backbone)
    paired = _nearly_singular(J, backbone)
    if paired.size:
        near = rows[paired]
        beyond = _beyond_fold(position[near], rotation[near], bends[paired], J[paired], backbone)
        more, others, _ = _solved(position, rotation, near, beyond, backbone)
        rows, bends = np.concatenate([rows, more]), np.concatenate([bends, others])
    return rows, bends


def _solved(position: Array, rotation: Array, rows: Index, bends: Array,
            backbone: Backbone) -> tuple[Index, Array, Array]:  # fmt: skip
    """Return rows, solutions and Jacobians of those starts that lead to a solution."""
    given = bends
    bends, miss, J = newton(position[rows], rotation[rows], given, backbone)
    arc = np.flatnonzero(one_arc(position, rotation, backbone)[rows])
    if arc.size:  # rounding over a singular value of nothing would carry it along the continuum
        which = rows[arc]
        bends[arc], miss[arc], J[arc] = newton(position[which], rotation[which], given[arc], backbone, 1e-9)
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


def _beyond_fold(position: Array, rotation: Array, bends: Array, J: Array, backbone: Backbone) -> Array:
    """Return starts for the solutions that nearly singular ones are paired with."""
    step = 1e-4
    left, least, right = np.linalg.svd(J)
    u, least, along = left[..., -1], least[:, -1], right[:, -1]
    _, beside = misses(position, rotation, bends + step * along.reshape(-1, 3, 2), backbone)
    curved = np.einsum("ni,nij,nj->n", u, beside - J, along) / step
    far = np.clip(-2 * least / np.where(curved == 0, 1.0, curved), -1.0, 1.0)
    return np.asarray(bends + far[:, None, None] * along.reshape(-1, 3, 2))


def _within(rows: Index, bends: Array, backbone: Backbone, count: int) -> tuple[Array, Index]:
    """Return the distinct solutions within the limits, by total bend, and how many each target has."""
    limits = np.asarray(backbone.limits)
    angle = np.hypot(bends[..., 0], bends[..., 1])
    inside = (angle <= limits + _OVER).all(axis=-1)
    rows, bends, angle = rows[inside], bends[inside], angle[inside]
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
    known = np.arange(packed.shape[1]) < number[:, None]
    for later in range(1, packed.shape[1]):
        apart = np.abs(packed[:, later, None] - packed[:, :later]).max(axis=(-1, -2))
        known[:, later] &= ~((apart < SAME) & known[:, :later]).any(axis=-1)
    number = known.sum(axis=-1)
    first = np.argsort(~known, axis=-1, kind="stable")
    packed = np.where(known[..., None, None], packed, np.nan)
    packed = np.take_along_axis(packed, first[..., None, None], axis=1)
    return packed[:, : max(1, int(number.max(initial=0)))], number

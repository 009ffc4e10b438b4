"""Bend to muscle lengths and back, for muscles parallel to the backbone or in straight spans.

Parallel muscles measure the hinges' angles: L_i = L0 - r (g . u_i), g their sum over the sections that the muscle runs
through. That is the arc's length L0 - r (bend . u_i) but for what hinge pairs bend less than they turn, of second order
in the link pitch. A muscle that runs through several sections measures the sum of what each of them takes.

`bend` is the vector of the arm's coordinates, shape (..., 2 S), see `shape`.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import hinges, muscles, spans
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.mechanics.muscles import count, slices
from contarm_sim.mechanics.shape import bends_of
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section

_CORRECTIONS = 60
"""Most steps from lengths to bend."""


def section_angles(bend: Any, section: Section, routing: Routing) -> tuple[Array, Array]:
    """Return the sums of joint angles [rad], shape (..., 2), of a section's bend, whose energy is (EI/L) |sum|^2/2.

    And their derivative by the bend, shape (..., 2, 2).
    """
    bend = as_vectors(bend, 2, "bend")
    if routing.path == "spans":
        return bend, np.broadcast_to(np.eye(2), (*bend.shape, 2))
    return hinges.angles(bend, section.links)


def lengths_from_bend(bend: Any, arm: Arm) -> Array:
    """Return the muscle lengths [m], shape (..., n), of the uniformly bent chain at bends [rad], shape (..., 2 S).

    Raises:
        InputError: an arm without muscles.
    """
    bends = bends_of(bend, arm)
    return np.concatenate([_lengths(bends, arm, group) for group in _groups(arm)], axis=-1)


def length_jacobian(bend: Any, arm: Arm) -> Array:
    """Return dL/dbend [m/rad], shape (..., n, 2 S)."""
    bends, groups = bends_of(bend, arm), _groups(arm)
    parts = [_slopes(bends, arm, group) for group in groups]
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=-2)


def bend_from_lengths(lengths: Any, arm: Arm, extrapolated: bool = False) -> tuple[Array, Array]:
    """Return (bend [rad], shape (..., 2 S); residual [m], shape (...)) of measured muscle lengths [m], shape (..., n).

    Length differences fix the bend; the residual is what their common mode is off by, zero when all joints of a section
    bend alike. Of several sections it is that of the section whose is largest.

    Args:
        extrapolated: whether the lengths are those of infinitely many links.

    Raises:
        InputError: a section whose muscles fix no bend.
    """
    if len(arm.sections) > 1 or not muscles.evenly_spaced(arm.group.routing.angles):
        return _bends_from_lengths(lengths, arm, extrapolated)
    routing = arm.routing
    if routing.path == "spans":
        return spans.bend_from_lengths(lengths, guides(arm, arm.group, 0))
    deltas = as_vectors(lengths, routing.count, "muscle_lengths") - arm.length
    total = muscles.bend_of_lengths(deltas, routing.radius, routing.angles)
    return total if extrapolated else hinges.bend_from_angles(total, arm.links), deltas.mean(axis=-1)


def arc_deltas(bend: Any, arm: Arm) -> Array:
    """Return the length changes [m], shape (..., n), that muscles of arcs have: -r u . (bends that they run through).

    Source: paper eq. 6 to 9; through several sections the terms add up.
    """
    bends = bends_of(bend, arm)
    parts = []
    for group in _groups(arm):
        total = bends[..., group.first, :]
        for number in range(group.first + 1, group.section + 1):
            total = total + bends[..., number, :]
        parts.append(muscles.deltas_from_bend(total, group.routing.radius, group.routing.angles))
    return np.concatenate(parts, axis=-1)


def arc_jacobian(arm: Arm) -> Array:
    """Return d(arc_deltas)/dbend [m/rad], shape (n, 2 S): they are linear."""
    return arc_deltas(np.eye(2 * len(arm.sections)), arm).T


def arc_differences(arm: Arm) -> Array:
    """Return the same less what the muscles of each section have in common, shape (n, 2 S)."""
    J = arc_jacobian(arm).copy()
    for own in slices(arm):
        J[own] -= J[own].mean(axis=0)
    return J


def bend_from_arc_deltas(deltas: Any, arm: Arm) -> tuple[Array, Array]:
    """Return (bend [rad], shape (..., 2 S); residual [m], shape (..., n)) of muscle length changes [m], shape (..., n).

    The inverse of `arc_deltas`, by least squares of differences; the residual is what no arcs have.

    Raises:
        InputError: a section whose muscles fix no bend.
    """
    deltas = as_vectors(deltas, count(arm), "deltas")
    bend = _from_linear(deltas, arm)
    return bend, deltas - arc_deltas(bend, arm)


def _bends_from_lengths(lengths: Any, arm: Arm, extrapolated: bool) -> tuple[Array, Array]:
    """Invert any lengths: those of arcs, corrected by what the chain's are off."""
    straight = lengths_from_bend(np.zeros(2 * len(arm.sections)), arm)
    lengths = as_vectors(lengths, len(straight), "muscle_lengths")
    bend = _from_linear(lengths - straight, arm)
    if extrapolated and all(group.routing.path == "parallel" for group in arm.groups):
        left = lengths - straight - arc_deltas(bend, arm)
    else:
        for _ in range(_CORRECTIONS):
            off = _from_linear(lengths - lengths_from_bend(bend, arm), arm)
            bend = bend + off
            if np.abs(off).max(initial=0.0) < 1e-14:
                break
        left = lengths - lengths_from_bend(bend, arm)
    common = np.stack([left[..., part].mean(axis=-1) for part in slices(arm)], axis=-1)
    largest = np.abs(common).argmax(axis=-1)[..., None]
    return bend, np.take_along_axis(common, largest, axis=-1)[..., 0]


def _from_linear(deltas: Array, arm: Arm) -> Array:
    """Return the bend [rad] that the arcs' linear lengths give for length changes [m], by least squares."""
    return (_inverse(arm) @ deltas[..., None])[..., 0]


@lru_cache(maxsize=64)
def _inverse(arm: Arm) -> Array:
    """Return what inverts `arc_deltas`, shape (2 S, n), blind to what the muscles of a group have in common."""
    seen = arc_differences(arm)
    if np.linalg.matrix_rank(seen) < seen.shape[1]:
        raise InputError("muscles", "too few", "three or more that end with each section, whose lengths fix its bend")
    inverse = np.asarray(np.linalg.pinv(seen), dtype=float)
    inverse.setflags(write=False)
    return inverse


def _groups(arm: Arm) -> tuple[MuscleGroup, ...]:
    if not arm.groups:
        raise InputError("muscle.count", 0, "an arm with muscles")
    return arm.groups


def _lengths(bends: Array, arm: Arm, group: MuscleGroup) -> Array:
    """Return the lengths [m] of one group's muscles, shape (..., n), at bends of all sections, shape (..., S, 2)."""
    routing, crossed = group.routing, range(group.first, group.section + 1)
    if routing.path == "spans":
        total = spans.lengths_from_bend(bends[..., group.first, :], guides(arm, group, group.first))
        for number in crossed[1:]:
            total = total + spans.lengths_from_bend(bends[..., number, :], guides(arm, group, number))
        return total
    turned = _turned(bends, arm, group.first)
    for number in crossed[1:]:
        turned = turned + _turned(bends, arm, number)
    return group.length + muscles.deltas_from_bend(turned, routing.radius, routing.angles)


def _turned(bends: Array, arm: Arm, number: int) -> Array:
    """Return what parallel muscles feel of a section: the sums of its joint angles."""
    return section_angles(bends[..., number, :], arm.sections[number], arm.routings[number])[0]


def _slopes(bends: Array, arm: Arm, group: MuscleGroup) -> Array:
    """Return the derivatives of one group's lengths [m/rad], shape (..., n, 2 S)."""
    routing = group.routing
    parts = []
    for number, section in enumerate(arm.sections):
        own = bends[..., number, :]
        if not group.crosses(number):
            parts.append(np.zeros((*own.shape[:-1], routing.count, 2)))
        elif routing.path == "spans":
            parts.append(spans.length_jacobian(own, guides(arm, group, number)))
        else:
            turn = section_angles(own, section, arm.routings[number])[1]
            parts.append(-routing.radius * muscles.directions(routing.angles) @ turn)
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=-1)


def guides(arm: Arm, group: MuscleGroup, number: int) -> spans.Guides:
    """Return where a group's straight spans run through a section, numbered from 0."""
    section, routing = arm.sections[number], group.routing
    last = number == group.section
    return spans.Guides(
        section.length, routing.radius, section.guide_height, section.links, routing.angles,
        root=section.guide_height if number == group.first else 0.0,
        end=0.0 if last else arm.sections[number + 1].guide_height,
    )  # fmt: skip

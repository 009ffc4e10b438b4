"""Bend to muscle lengths and back, and the chain's tip, for muscles parallel to the backbone or in straight spans.

Parallel muscles measure the hinges' angles: L_i = L0 - r (g . u_i), g their sum over the chain. That is the arc's
length L0 - r (bend . u_i) but for what hinge pairs bend less than they turn, of second order in the link pitch.

All this is of the n muscles of one section; arms of several are refused.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics import chain, hinges, muscles, spans
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.model.arm import Arm
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section


def joint_angles(bend: Any, arm: Arm) -> tuple[Array, Array]:
    """Return the sums of joint angles [rad], shape (..., 2), that store the elastic energy (EI/L0) |sum|^2/2 of a bend.

    And their derivative by the bend [rad], shape (..., 2, 2).
    """
    return section_angles(bend, arm.section, arm.routing)


def section_angles(bend: Any, section: Section, routing: Routing) -> tuple[Array, Array]:
    """Return the same of a section whose muscles are routed so."""
    bend = as_vectors(bend, 2, "bend")
    if routing.path == "spans":
        return bend, np.broadcast_to(np.eye(2), (*bend.shape, 2))
    return hinges.angles(bend, section.links)


def lengths_from_bend(bend: Any, arm: Arm) -> Array:
    """Return the muscle lengths [m], shape (..., n), of the uniformly bent chain at bends [rad], shape (..., 2).

    Raises:
        InputError: an arm without muscles, or of several sections.
    """
    routing = arm.group.routing
    if routing.path == "spans":
        return spans.lengths_from_bend(bend, _guides(arm))
    return arm.length + muscles.deltas_from_bend(hinges.angles(bend, arm.links)[0], routing.radius, routing.angles)


def length_jacobian(bend: Any, arm: Arm) -> Array:
    """Return dL/dbend [m/rad], shape (..., n, 2)."""
    routing = arm.routing
    if routing.path == "spans":
        return spans.length_jacobian(bend, _guides(arm))
    return -routing.radius * muscles.directions(routing.angles) @ hinges.angles(bend, arm.links)[1]


def bend_from_lengths(lengths: Any, arm: Arm, extrapolated: bool = False) -> tuple[Array, Array]:
    """Return (bend [rad], shape (..., 2); residual [m], shape (...)) of measured muscle lengths [m], shape (..., n).

    Length differences fix the bend; the residual is what their common mode is off by, zero when all joints bend alike.

    Args:
        extrapolated: whether the lengths are those of infinitely many links.
    """
    routing = arm.routing
    if routing.path == "spans":
        return spans.bend_from_lengths(lengths, _guides(arm))
    deltas = as_vectors(lengths, routing.count, "muscle_lengths") - arm.length
    total = muscles.bend_of_lengths(deltas, routing.radius, routing.angles)
    return total if extrapolated else hinges.bend_from_angles(total, arm.links), deltas.mean(axis=-1)


def chain_tip(bend: Any, arm: Arm, extrapolated: bool = False) -> Array:
    """Return the tip [m], shape (..., 3), of the unloaded chain whose muscles have the lengths of a bend [rad].

    Args:
        extrapolated: from this chain and one of half the links, as motions are.
    """
    form = chain if arm.routing.path == "spans" else hinges
    tip, half = form.tip(bend, arm.length, arm.links), arm.links // 2
    if not extrapolated:
        return tip
    return tip + chain.richardson(arm.links, half) * (tip - form.tip(bend, arm.length, half))


def _guides(arm: Arm) -> spans.Guides:
    return spans.Guides(arm.length, arm.muscle_radius, arm.guide_height, arm.links, arm.routing.angles)

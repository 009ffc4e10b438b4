"""The arm's closed forms: where its backbone lies at a bend, as arcs and as the chain of links that is simulated.

`bend` is the vector of the arm's coordinates [rad], shape (..., 2 S) of S sections: bend x and y of section 1, then of
section 2, and so on; `bends_of` gives it an axis for the sections.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc, chain, hinges, sections
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.kinematics.backbone import LARGEST, Backbone
from contarm_sim.model.arm import Arm

_SAID_STRAIGHT = np.radians(0.5)

LENGTH_SHARE = 0.99
"""Of the lengths that muscles can take, what bends may use: the simulated chain's differ a little from the arc's."""

LEAST = 1e-6
"""Least limit of a bend angle [rad]."""


def backbone(arm: Arm, chained: bool = False, limits: Any = None) -> Backbone:
    """Return an arm's sections as the kinematics sees them.

    Args:
        chained: as chains of ball joints, not as arcs.
        limits: largest bend angle of each section [rad], or one number for all; default `bend_limits`.
    """
    links = tuple(section.links for section in arm.sections) if chained else None
    lengths = tuple(section.length for section in arm.sections)
    return Backbone(lengths=lengths, links=links, limits=bend_limits(arm) if limits is None else limits)


def bend_limits(arm: Arm) -> tuple[float, ...]:
    """Return the bend angle of each section [rad] up to which its own muscles have lengths that they can take.

    Nearly: see `LENGTH_SHARE`.

    At most `kinematics.backbone.LARGEST`; muscles that run through several sections set no limit to one of them.
    """
    out = [LARGEST] * len(arm.sections)
    for group in arm.groups:
        if group.first == group.section:
            shortest, longest = group.length_range
            room = LENGTH_SHARE * min(group.length - shortest, longest - group.length) / group.routing.radius
            out[group.section] = min(out[group.section], max(room, LEAST))
    return tuple(out)


def as_coordinates(bend: Any, arm: Arm) -> Array:
    """Return the coordinates of an arm [rad], shape (..., 2 S), each section's bend shorter than pi.

    Args:
        bend: these, or bends with an axis for the sections, shape (..., S, 2).

    Raises:
        InputError: not finite, of the wrong shape, or a bend angle of pi or more.
    """
    count = len(arm.sections)
    array = np.asarray(bend)
    if count > 1 and array.ndim >= 2 and array.shape[-2:] == (count, 2):
        bend = array.reshape(*array.shape[:-2], 2 * count)
    coordinates = as_vectors(bend, 2 * count, "bend")
    arc.as_bend(coordinates.reshape(-1, 2))
    return coordinates


def described(bend: Array, arm: Arm) -> str:
    """Return a bend [rad], shape (2 S,), in words, in degrees."""
    if len(arm.sections) == 1:
        return arc.described(bend)
    parts = (arc.described(own) if np.hypot(*own) > _SAID_STRAIGHT else "no bend" for own in bends_of(bend, arm))
    return ", ".join(f"{part} of section {number}" for number, part in enumerate(parts, 1))


def bends_of(bend: Any, arm: Arm) -> Array:
    """Return the bends of all sections [rad], shape (..., S, 2), of coordinates, shape (..., 2 S)."""
    bend = as_vectors(bend, 2 * len(arm.sections), "bend")
    return bend.reshape(*bend.shape[:-1], -1, 2)


def transform(bend: Any, arm: Arm, xi: Any = 1.0) -> Array:
    """Return frames of the arcs at normalised arc lengths xi, shape (..., 4, 4); `xi` broadcasts against the leads."""
    if len(arm.sections) == 1:
        return arc.transform(bend, arm.length, xi)
    return sections.transform(bends_of(bend, arm), backbone(arm), xi)


def position(bend: Any, arm: Arm, xi: Any = 1.0) -> Array:
    """Return places on the arcs at normalised arc lengths xi [m], shape (..., 3)."""
    return arc.position(bend, arm.length, xi) if len(arm.sections) == 1 else transform(bend, arm, xi)[..., :3, 3]


def rotation(bend: Any, arm: Arm, xi: Any = 1.0) -> Array:
    """Return orientations of the arcs at normalised arc lengths xi, shape (..., 3, 3)."""
    return arc.rotation(bend, xi) if len(arm.sections) == 1 else transform(bend, arm, xi)[..., :3, :3]


def tip_jacobian(bend: Any, arm: Arm, xi: Any = 1.0) -> Array:
    """Return dp/dbend of the arcs at normalised arc lengths xi [m/rad], shape (..., 3, 2 S)."""
    if len(arm.sections) == 1:
        return arc.jacobian(bend, arm.length, xi)
    return sections.jacobian(bends_of(bend, arm), backbone(arm), xi)[..., :3, :]


def stations(arm: Arm) -> Array:
    """Return the normalised arc lengths of base, links and tip, shape (N + 1,) of N links in all."""
    if len(arm.sections) == 1:
        return np.arange(arm.links + 1) / arm.links
    ends = 0.0
    out: list[Array] = [np.zeros(1)]
    for section in arm.sections:
        out.append((ends + section.link_pitch * np.arange(1.0, section.links + 1)) / arm.length)
        ends += section.length
    out[-1][-1] = 1.0
    return np.concatenate(out)


def section_frames(bend: Any, arm: Arm, chained: bool = True) -> Array:
    """Return the frame at each section's end in its own base frame, shape (..., S, 4, 4).

    Args:
        chained: of the unloaded chain of links that is simulated, see `chain_tip`; False: of the arcs.
    """
    bends = bends_of(bend, arm)
    out = np.empty((*bends.shape[:-1], 4, 4))
    for number, section in enumerate(arm.sections):
        own = bends[..., number, :]
        if not chained or arm.routings[number].path == "spans":
            out[..., number, :, :] = arc.transform(own, section.length)
            if chained:
                out[..., number, :3, 3] = chain.tip(own, section.length, section.links)
        else:
            out[..., number, :, :] = hinges.frames(own, section.length, section.links)[..., -1, :, :]
    return out


def posed_frames(qpos: Array, arm: Arm) -> Array:
    """Return the same, shape (..., S, 4, 4), of simulated chains by their joint angles [rad], shape (..., dofs)."""
    first, out = 0, np.empty((*qpos.shape[:-1], len(arm.sections), 4, 4))
    for number, section in enumerate(arm.sections):
        each = 2 if section.torsional_stiffness is None else 3
        own = qpos[..., first : first + each * section.links]
        angles = own.reshape(*own.shape[:-1], section.links, each)
        out[..., number, :, :] = hinges.chain_frame(angles, section.link_pitch)
        first += each * section.links
    return out


def end_to_end(frames: Array) -> Array:
    """Return the tip's frame, shape (..., 4, 4), of each section's end in its base frame, shape (..., S, 4, 4)."""
    out = frames[..., 0, :, :]
    for number in range(1, frames.shape[-3]):
        out = out @ frames[..., number, :, :]
    return out


def chain_tip(bend: Any, arm: Arm, extrapolated: bool = False) -> Array:
    """Return the tip [m], shape (..., 3), of the unloaded chain whose muscles have the lengths of a bend [rad].

    Args:
        extrapolated: from this chain and one of half the links, as motions are.
    """
    tip = _chain_tip(bend, arm)
    if not extrapolated:
        return tip
    half = halved(arm)
    return tip + chain.richardson(arm.links, half.links) * (tip - _chain_tip(bend, half))


def _chain_tip(bend: Any, arm: Arm) -> Array:
    if len(arm.sections) == 1:
        form = chain if arm.routing.path == "spans" else hinges
        return form.tip(bend, arm.length, arm.links)
    return end_to_end(section_frames(bend, arm))[..., :3, 3]


def halved(arm: Arm, divisor: int = 2, fewest: int = 2) -> Arm:
    """Return an arm of half the links, or of another share, from which one extrapolates.

    Of several sections every one must have a whole number of links then: the error of each is of second order in its
    own link pitch, and all pitches must grow alike.

    Args:
        fewest: links that a section must have.

    Raises:
        InputError: a section has fewer, or no whole number would be left.
    """
    several = len(arm.sections) > 1
    for number, section in enumerate(arm.sections):
        said = f"{section.links} of section {number + 1}" if several else section.links
        if section.links < fewest:
            raise InputError("links", said, f"at least {fewest}, a part of which make the coarser chain")
        if several and section.links % divisor:
            raise InputError("links", said, f"a multiple of {divisor}, to extrapolate from fewer links")
    fewer = tuple(replace(section, links=section.links // divisor) for section in arm.sections)
    return replace(arm, sections=fewer)

"""How the tip of a uniformly bent arm gives way to a small force, in closed form.

A change dk(s) of the material curvature moves the tip by the integral of G dk, G's columns being the material axes
crossed with the way to the tip. It costs EI |dk|^2/2 along the backbone and, through m = integral of dk, what the
muscles' springs resist with: K_m = r^2 sum_i (dF/dL)_i u_i u_i^T. Minimising gives

    C = (1/EI) ( integral of G G^T - A K_m (EI + L K_m)^-1 A^T ),   A = integral of G.

Straight, this is L^3/(12 EI) + (L/2)^2/(EI/L + k_m): a part that no length feels, so muscles can stiffen at most
fourfold. A twist that the backbone allows adds the integral of g g^T over GJ + r^2 sum_i T_i L/L_i, g the tangent
crossed with the way to the tip: twisted muscles pull back, the more the shorter they are. All this is exact for muscles
that run parallel to the backbone. Straight spans between disks also shorten with the square of the bend between them;
tensions therefore soften the arm, and EI above is EI - (sum of T) h^2/12, h the link pitch.

Of several sections, E and L above are diagonal, each section's own, m holds the integrals over all of them, A too, and
K_m = J^T diag(dF/dL) J with J = dL/dbend of the arcs: C = integral of G G^T/EI - A E^-1 K_m (E + L K_m)^-1 A^T.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.kinematics.muscles import directions
from contarm_sim.mechanics import muscles, shape
from contarm_sim.mechanics.routing import arc_jacobian
from contarm_sim.model.arm import Arm

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


def buckling_tension(arm: Arm, number: int = 0) -> float:
    """Return the sum of tensions [N] that buckles a section between the disks of straight spans.

    inf if no muscles run through it in spans.
    """
    section = arm.sections[number]
    if not any(group.crosses(number) and group.routing.path == "spans" for group in arm.groups):
        return float("inf")
    return 12 * section.bending_stiffness / section.link_pitch**2


def softened_stiffness(tensions: Any, arm: Arm, number: int = 0) -> float:
    """Return the bending stiffness [N m^2] that tensions leave of a section's EI: all, but for straight spans.

    Args:
        tensions: of the arm's muscles [N], shape (n,).
        number: of the section, from 0.

    Raises:
        InputError: none: tensions [N] this large buckle the arm between its disks.
    """
    tensions = as_vectors(tensions, muscles.count(arm), "tensions")
    parts = zip(arm.groups, muscles.slices(arm), strict=True)
    total = sum(
        float(np.sum(tensions[own])) for group, own in parts if group.crosses(number) and group.routing.path == "spans"
    )
    limit = buckling_tension(arm, number)
    if total >= limit:
        raise InputError("tensions", f"{total:.4g} N in all", f"less than {limit:.4g} N: more buckles the arm")
    return arm.sections[number].bending_stiffness * (1 - total / limit)


def tip_compliance(bend: Any, tensions: Any, slopes: Any, arm: Arm) -> Array:
    """Return the tip's displacement by a small force there [m/N], shape (3, 3), base frame, without gravity.

    Args:
        bend: uniform bends [rad], shape (2 S,).
        tensions: of the muscles [N], shape (n,).
        slopes: dF/dL of the muscles [N/m], shape (n,).
    """
    bends, slopes = shape.bends_of(bend, arm), as_vectors(slopes, muscles.count(arm), "slopes")
    tip, start = shape.position(bend, arm), 0.0
    spread, lever = np.zeros((3, 3)), []
    for number, section in enumerate(arm.sections):
        xi, weight = start + 0.5 * (1 + _NODES) * section.length, 0.5 * section.length * _WEIGHTS
        frames = shape.transform(bend, arm, xi / arm.length)
        start += section.length
        to_tip, axes = tip - frames[:, :3, 3], frames[:, :3, :3]
        # Bending towards x turns about the material y axis, bending towards y about minus x.
        G = np.stack([np.cross(axes[:, :, 1], to_tip), np.cross(-axes[:, :, 0], to_tip)], axis=-1)
        lever.append(np.einsum("s,sij->ij", weight, G))
        spread += np.einsum("s,sij,skj->ik", weight, G, G) / softened_stiffness(tensions, arm, number)
        if section.torsional_stiffness is not None:
            twist = np.cross(axes[:, :, 2], to_tip)
            spread += np.einsum("s,si,sk->ik", weight, twist, twist) / _torsion(bends, tensions, arm, number)
    A = np.concatenate(lever, axis=-1)
    J = arc_jacobian(arm)
    springs = (J.T * slopes) @ J
    bending = np.repeat([softened_stiffness(tensions, arm, k) for k in range(len(arm.sections))], 2)
    lengths = np.repeat([section.length for section in arm.sections], 2)
    held = (A / bending) @ springs @ np.linalg.inv(np.diag(bending) + lengths[:, None] * springs) @ A.T
    return np.asarray(spread - held)


def _torsion(bends: Array, tensions: Any, arm: Arm, number: int) -> float:
    """Return what a section resists twist with [N m^2]: its GJ, and the helices of the muscles that run through it."""
    section = arm.sections[number]
    assert section.torsional_stiffness is not None
    tensions = as_vectors(tensions, muscles.count(arm), "tensions")
    torsion = section.torsional_stiffness
    for group, own in zip(arm.groups, muscles.slices(arm), strict=True):
        if group.crosses(number):
            radius = group.routing.radius
            shortened = 1 - radius / section.length * directions(group.routing.angles) @ bends[number]  # L_i/L
            torsion += radius**2 * float((tensions[own] / shortened).sum())
    return torsion

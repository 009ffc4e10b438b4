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
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.kinematics.muscles import directions
from contarm_sim.model.arm import Arm

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


def buckling_tension(arm: Arm) -> float:
    """Return the sum of tensions [N] that buckles the arm between the disks of straight spans; inf if parallel."""
    return 12 * arm.bending_stiffness / arm.link_pitch**2 if arm.routing.path == "spans" else float("inf")


def softened_stiffness(tensions: Any, arm: Arm) -> float:
    """Return the bending stiffness [N m^2] that tensions leave of EI: all, unless muscles run in straight spans.

    Raises:
        InputError: none: tensions [N] this large buckle the arm between its disks.
    """
    total, limit = float(np.sum(as_vectors(tensions, arm.routing.count, "tensions"))), buckling_tension(arm)
    if total >= limit:
        raise InputError("tensions", f"{total:.4g} N in all", f"less than {limit:.4g} N: more buckles the arm")
    return arm.bending_stiffness * (1 - total / limit)


def tip_compliance(bend: Any, tensions: Any, slopes: Any, arm: Arm) -> Array:
    """Return the tip's displacement by a small force there [m/N], shape (3, 3), base frame, without gravity.

    Args:
        bend: uniform bend [rad], shape (2,).
        tensions: of the muscles [N], shape (n,).
        slopes: dF/dL of the muscles [N/m], shape (n,).
    """
    bend, slopes = as_vectors(bend, 2, "bend"), as_vectors(slopes, arm.routing.count, "slopes")
    stiffness, length = softened_stiffness(tensions, arm), arm.length
    xi, weight = 0.5 * (1 + _NODES), 0.5 * length * _WEIGHTS
    to_tip = arc.position(bend, length) - arc.position(bend, length, xi)
    axes = arc.rotation(bend, xi)
    # Bending towards x turns about the material y axis, bending towards y about minus x.
    G = np.stack([np.cross(axes[:, :, 1], to_tip), np.cross(-axes[:, :, 0], to_tip)], axis=-1)
    A = np.einsum("s,sij->ij", weight, G)
    u = directions(arm.routing.angles)
    springs = arm.muscle_radius**2 * (u.T * slopes) @ u
    held = A @ springs @ np.linalg.inv(stiffness * np.eye(2) + length * springs) @ A.T
    bending = (np.einsum("s,sij,skj->ik", weight, G, G) - held) / stiffness
    if arm.torsional_stiffness is None:
        return bending
    twist = np.cross(axes[:, :, 2], to_tip)
    shortened = 1 - arm.muscle_radius / length * u @ bend  # L_i/L
    torsion = arm.torsional_stiffness + arm.muscle_radius**2 * float(
        (as_vectors(tensions, arm.routing.count, "tensions") / shortened).sum()
    )
    return bending + np.einsum("s,si,sk->ik", weight, twist, twist) / torsion

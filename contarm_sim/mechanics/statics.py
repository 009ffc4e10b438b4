"""Muscle tensions that hold a uniform bend.

With the chain's elastic energy (EI/length) |bend|^2/2 and the work of tensions T on lengths L(bend), equilibrium
is (EI/length) bend + J^T T = 0, J = dL/dbend: two equations, three tensions. The free direction is co-contraction:
the null vector of J^T, near (1, 1, 1), is scaled so that the slackest muscle has the least tension asked for.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_vectors, sinc, sinc_slope
from contarm_sim.kinematics.muscles import DIRECTIONS


def length_jacobian(bend: Any, arm: Arm) -> Array:
    """Return dL/dbend [m/rad] of the chain's muscle lengths, shape (..., 3, 2)."""
    bend = as_vectors(bend, 2, "bend")
    n = arm.links
    half = np.hypot(bend[..., 0], bend[..., 1]) / (2 * n)
    along = (bend @ DIRECTIONS.T)[..., None] * bend[..., None, :]
    J = -arm.muscle_radius * sinc(half)[..., None, None] * DIRECTIONS
    J = J - (arm.muscle_radius / (4 * n**2)) * sinc_slope(half)[..., None, None] * along
    return J - (arm.length / (4 * n**2)) * (sinc(half)[..., None] * bend)[..., None, :]


def cocontraction(bend: Any, arm: Arm) -> Array:
    """Return tensions that hold the bend by themselves, shape (..., 3), of mean 1: the null vector of J^T."""
    J = length_jacobian(bend, arm)
    null = np.cross(J[..., 0], J[..., 1])
    return null / null.mean(axis=-1, keepdims=True)


def holding_tensions(bend: Any, arm: Arm, min_tension: float | None = None, rate: Any = None) -> Array:
    """Return the least tensions T [N] that hold a bend without gravity, shape (..., 3).

    Args:
        bend: bend vectors [rad], shape (..., 2).
        min_tension: tension of the slackest muscle [N]; default `arm.muscle.min_tension`.
        rate: velocity of the bend [rad/s], shape (..., 2), whose Kelvin-Voigt damping is carried too.

    Raises:
        InputError: no pulling tensions hold the bend. That needs few links: their straight muscle spans
            cut the corner so far that even the outer muscle pulls inwards.
    """
    bend = as_vectors(bend, 2, "bend")
    least = arm.muscle.min_tension if min_tension is None else min_tension
    elastic = bend if rate is None else bend + arm.damping_time * as_vectors(rate, 2, "rate")
    J = length_jacobian(bend, arm)
    gram = J.swapaxes(-1, -2) @ J
    moment = -(arm.bending_stiffness / arm.length) * elastic
    tensions = (J @ np.linalg.solve(gram, moment[..., None]))[..., 0]
    null = cocontraction(bend, arm)
    if not np.all(null > 0):
        worst = np.hypot(bend[..., 0], bend[..., 1])[~np.all(null > 0, axis=-1)].min()
        raise InputError(
            "bend_angle",
            f"{worst:.4g} rad",
            f"bends that pulling muscles can hold with {arm.links} links: more links, or bend less",
        )
    return tensions + ((least - tensions) / null).max(axis=-1, keepdims=True) * null

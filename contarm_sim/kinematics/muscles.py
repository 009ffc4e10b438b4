"""Bend to muscle length changes and back, and the possibility map (paper eq. 6-13).

Muscle i sits at an angle psi_i on the circle of radius r, the paper's three at 0, 2 pi/3 and 4 pi/3, so
l_i = -r (bend . u_i) with u_i = (cos psi_i, sin psi_i): linear, hence free of the
singularity of the paper's theta(q) and lambda(q).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_vectors

Angles = tuple[float, ...]

PAPER: Angles = (0.0, 2 * np.pi / 3, 4 * np.pi / 3)
"""Angles psi_i of the paper's three muscles about +Z from +X [rad]."""

_ROUNDING = 1e-14


@lru_cache
def directions(angles: Angles = PAPER) -> Array:
    """Return the unit vectors u_i from the backbone to the muscles, shape (n, 2), of angles psi_i [rad].

    Sines of 0, 1/2 and 1 come out as these: the paper's directions add up to nothing, exactly.
    """
    quarters = np.round(np.array(angles) / (0.5 * np.pi))
    sine = np.sin(np.array(angles) - 0.5 * np.pi * quarters)
    halves = 0.5 * np.round(2 * sine)
    sine = np.where(np.abs(sine - halves) < _ROUNDING, halves, sine)
    cosine = np.sqrt(1 - sine**2)
    turned = np.stack([[cosine, sine], [-sine, cosine], [-cosine, -sine], [sine, -cosine]])
    u = np.take_along_axis(turned, (quarters.astype(int) % 4)[None, None], axis=0)[0].T + 0.0
    u.setflags(write=False)
    return u


@lru_cache
def evenly_spaced(angles: Angles) -> bool:
    """Tell whether `bend_of_lengths` holds: sum u_i = 0 and sum u_i u_i^T = (n/2) I."""
    u = directions(angles)
    off = np.abs(u.T @ u - 0.5 * len(angles) * np.eye(2)).max()
    return bool(len(angles) >= 3 and np.abs(u.sum(axis=0)).max() < 1e-12 and off < 1e-12)


def towards_muscles(bend: Array, angles: Angles = PAPER) -> Array:
    """Return bend . u_i, shape (..., n), term by term: a bend gives the same bits alone or among others."""
    u = directions(angles)
    return bend[..., :1] * u[:, 0] + bend[..., 1:] * u[:, 1]


def bend_of_lengths(lengths: Array, radius: float, angles: Angles = PAPER) -> Array:
    """Return the bend [rad], shape (..., 2), that fits lengths [m], shape (..., n), best; term by term.

    Least squares, of differences alone: what all lengths have in common does not matter. The angles must be three or
    more, evenly spaced, so that sum u_i u_i^T = (n/2) I.

    Raises:
        InputError: fewer than three muscles, which fix no bend.
    """
    if len(angles) < 3:
        raise InputError("muscle.count", len(angles), "three muscles or more, whose lengths fix a bend")
    u = directions(angles)
    total = lengths[..., 0, None] * u[0]
    for i in range(1, len(angles)):
        total = total + lengths[..., i, None] * u[i]
    return -(2 / (len(angles) * radius)) * total


def deltas_from_bend(bend: Any, radius: float, angles: Angles = PAPER) -> Array:
    """Return muscle length changes [m] (shortening < 0), shape (..., n), of the arc."""
    return -radius * towards_muscles(as_vectors(bend, 2, "bend"), angles)


def bend_from_deltas(
    deltas: Any, radius: float, tolerance: float | None = None, angles: Angles = PAPER
) -> tuple[Array, Array]:
    """Return (bend [rad], shape (..., 2); residual [m], shape (...)) of muscle length changes.

    The residual is mean(deltas). An inextensible arc makes it zero; a bend exists for any
    deltas (their differences), but a residual means that no arc has these lengths.

    Raises:
        InputError: |residual| exceeds `tolerance` (None: never), or a bend angle of pi or more.
    """
    deltas = as_vectors(deltas, len(angles), "deltas")
    residual = deltas.mean(axis=-1)
    if tolerance is not None and np.any(np.abs(residual) > tolerance):
        worst = deltas[np.abs(residual) > tolerance][0] if deltas.ndim > 1 else deltas
        raise InputError(
            "deltas",
            f"({', '.join(f'{x:.6g}' for x in worst)}) m, whose sum is {worst.sum():.3g} m",
            f"a sum of 0 (within {len(angles) * tolerance:.1g} m): the backbone is inextensible",
        )
    bend = bend_of_lengths(deltas, radius, angles)
    if tolerance is not None and np.any(np.hypot(bend[..., 0], bend[..., 1]) >= np.pi):
        angle = np.hypot(bend[..., 0], bend[..., 1]).max()
        raise InputError("deltas", f"such that bend_angle is {angle:.6g} rad", "deltas of a bend angle below pi rad")
    return bend, residual


def possibility_ellipse(radius: float, bend_angle: float = np.pi, points: int = 181) -> Array:
    """Return the curve of (l_2, l_3) [m], shape (points, 2), at one bend angle in every plane.

    It is the ellipse l_2^2 + l_3^2 + l_2 l_3 = (3/4) (radius bend_angle)^2; at pi it bounds
    the paper's possibility map (its fig. "ellipse").
    """
    plane = np.linspace(-np.pi, np.pi, points)
    bend = bend_angle * np.stack([np.cos(plane), np.sin(plane)], axis=-1)
    return deltas_from_bend(bend, radius)[:, 1:]


def inside_possibility_map(deltas: Any, radius: float) -> Array:
    """Tell whether (l_2, l_3) lie inside the paper's ellipse, shape (...), bool.

    This proves only that bend_angle < pi: l_2^2 + l_3^2 + l_2 l_3 = (3/4) (r bend_angle)^2
    holds identically. It says nothing of l_1, of pressures, or of a target's being reachable.
    """
    deltas = as_vectors(deltas, 3, "deltas")
    l2, l3 = deltas[..., 1], deltas[..., 2]
    return np.asarray(l2**2 + l3**2 + l2 * l3 < 0.75 * (radius * np.pi) ** 2)

"""Inverse kinematics: tip position to bend, and the dome of reachable tips.

A tip of the arc lies on the ray at polar angle h = bend_angle/2 from the straight arm, at
distance length * sinc(h). So bend = 2 atan2(rho, z) (x, y)/rho inverts the forward kinematics
exactly, and the reachable set is a surface of revolution (the *dome*), not a spherical
shell and not a volume: a position has three coordinates, the section two degrees of freedom. Every
solution therefore reports its *miss*, the distance from the target to the tip it reaches.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError, UnreachableError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array, as_vectors, sinc, sinc_slope

Projection = Literal["refuse", "nearest", "ray", "paper"]
PROJECTIONS: tuple[Projection, ...] = get_args(Projection)

TOLERANCE = 3e-4
"""Miss below which a target counts as reached, as a fraction of length (0.11 mm for the paper's arm)."""

_LARGEST_HALF = 0.5 * np.pi * (1 - 1e-15)  # a few ulps short, so that no rounding makes a bend angle of pi
_AXIS = 1e-150  # nearer to the axis than this is on it
_FARTHEST = 1e6  # lengths
_GRID = np.linspace(0.0, _LARGEST_HALF, 65)
_CHUNK = 8192


@dataclass(frozen=True)
class Reach:
    """What the inverse kinematics found.

    Attributes:
        bend: bend vectors [rad], shape (..., 2).
        miss: distance from each target to the tip that `bend` reaches [m], shape (...).
        reachable: whether the miss is within the tolerance, shape (...), bool.
    """

    bend: Array
    miss: Array
    reachable: NDArray[np.bool_]


def meridian(bend_angle: Any, length: float) -> Array:
    """Return (rho, z) [m] of tips at bend angles [rad], shape (..., 2): the dome's profile."""
    h = 0.5 * np.asarray(bend_angle, dtype=float)
    return (length * sinc(h))[..., None] * np.stack([np.sin(h), np.cos(h)], axis=-1)


def bend_from_tip(target: Any, length: float, project: Projection = "refuse", tolerance: float | None = None) -> Reach:
    """Solve the inverse kinematics of tip positions, vectorised and in closed form.

    Args:
        target: tip positions in the base frame [m], shape (..., 3).
        length: backbone length [m].
        project: what to do with a target off the dome. `refuse` raises; `ray` keeps the target's
            direction from the base; `nearest` takes the nearest point of the dome (on the axis of
            symmetry, where a whole ring is nearest, the one towards muscle 1); `paper` evaluates
            the paper's phi_IK, which is right on the dome only.
        tolerance: largest miss [m] that counts as reached; default `TOLERANCE` * length.

    Raises:
        InputError: not finite, wrong shape, unknown projection, or (`paper`) a bend of pi or more.
        UnreachableError: `refuse`, and a miss exceeds the tolerance.
    """
    if project not in PROJECTIONS:
        raise InputError("project", repr(project), ", ".join(PROJECTIONS))
    target = as_vectors(target, 3, "target")
    if np.any(np.abs(target) > _FARTHEST * length):
        raise InputError("target", target.tolist(), f"within {_FARTHEST:g} backbone lengths")
    tolerance = TOLERANCE * length if tolerance is None else tolerance
    if project == "nearest":
        bend, miss = _nearest(target, length)
    elif project == "paper":
        bend = _paper(target, length)
        miss = np.linalg.norm(arc.position(bend, length) - target, axis=-1)
    else:
        bend, miss = _ray(target, length)
    if project == "refuse" and not np.all(miss <= tolerance):
        bend, miss = _accept_nearest(target, bend, miss, length, tolerance)
    reachable = np.asarray(miss <= tolerance)
    return Reach(bend, np.asarray(miss), reachable)


def _accept_nearest(target: Array, bend: Array, miss: Array, length: float, tolerance: float) -> tuple[Array, Array]:
    """Take the dome's nearest points for targets that their own rays miss; refuse those that are off the dome.

    Raises:
        UnreachableError: even the nearest point is farther than the tolerance; names the first such target.
    """
    off = miss > tolerance
    bend[off], miss = (near := _nearest(target[off], length))[0], np.array(miss)
    miss[off] = near[1]
    if np.any(miss > tolerance):
        index = int(np.argmax(miss > tolerance))
        first, found = target.reshape(-1, 3)[index], bend.reshape(-1, 2)[index]
        raise UnreachableError(first, float(miss.reshape(-1)[index]), arc.position(found, length), tolerance, index)
    return bend, miss


def _ray(target: Array, length: float) -> tuple[Array, Array]:
    """Keep the direction: the reached tip lies on the target's ray, so the miss is a difference of radii."""
    x, y, z = target[..., 0], target[..., 1], target[..., 2]
    rho = np.hypot(x, y)
    half = np.arctan2(rho, z)
    below = half > _LARGEST_HALF
    half = np.minimum(half, _LARGEST_HALF)
    bend = np.empty((*rho.shape, 2))
    per_rho = np.divide(2 * half, rho, out=np.zeros_like(rho), where=rho > _AXIS)
    np.multiply(per_rho, x, out=bend[..., 0])
    np.multiply(per_rho, y, out=bend[..., 1])
    miss = np.abs(np.hypot(rho, z) - length * sinc(half))
    if below.any():  # no bend below pi points there: the rim, or straight for a point on the axis
        rim = np.linalg.norm(arc.position(bend, length) - target, axis=-1)
        miss = np.where(below, rim, miss)
    return bend, miss


def _paper(target: Array, length: float) -> Array:
    """Return the paper's phi_IK (eq. 21) in the paper's plane.

    2 P_y/(F_1 F_2) equals 2 rho length/|P|^2 wherever it is not 0/0 (P_y = 0), which is how it is evaluated.
    """
    x, y = target[..., 0], target[..., 1]
    squared = np.einsum("...i,...i", target, target)
    per_rho = np.divide(2 * length, squared, out=np.full_like(squared, np.inf), where=squared != 0)
    with np.errstate(invalid="ignore"):
        bend_angle = per_rho * np.hypot(x, y)
    if not np.all(bend_angle < np.pi):
        raise InputError("target", "where the paper's phi_IK is pi or more", "0 <= phi_IK < pi, or --project nearest")
    return per_rho[..., None] * target[..., :2]


def _nearest(target: Array, length: float) -> tuple[Array, Array]:
    """Return the nearest point of the dome: a one-dimensional problem in the meridian plane."""
    flat = target.reshape(-1, 3)
    rho = np.hypot(flat[:, 0], flat[:, 1])
    half = np.concatenate(
        [_nearest_half(rho[i : i + _CHUNK], flat[i : i + _CHUNK, 2], length) for i in range(0, len(flat), _CHUNK)]
        or [np.empty(0)]
    )
    plane = np.arctan2(flat[:, 1], flat[:, 0])
    bend = 2 * half[:, None] * np.column_stack([np.cos(plane), np.sin(plane)])
    miss = np.linalg.norm(arc.position(bend, length) - flat, axis=-1)
    return bend.reshape(*target.shape[:-1], 2), miss.reshape(target.shape[:-1])


def _nearest_half(rho: Array, z: Array, length: float) -> Array:
    """Minimise the distance from (rho, z) to the meridian over h = bend_angle/2.

    The grid picks the basin (a target inside the dome can have two), bracketed Newton
    finds where the meridian's tangent is normal to the offset.
    """
    profile = meridian(2 * _GRID, length)
    squared = (profile[:, 0] - rho[:, None]) ** 2 + (profile[:, 1] - z[:, None]) ** 2
    best = squared.argmin(axis=1)
    low, high = _GRID[np.maximum(best - 1, 0)], _GRID[np.minimum(best + 1, len(_GRID) - 1)]
    h = _GRID[best]
    for _ in range(60):
        slope, curvature = _slope(h, rho, z, length)
        low, high = np.where(slope <= 0, h, low), np.where(slope > 0, h, high)
        step = np.divide(slope, curvature, out=np.full_like(h, np.inf), where=curvature > 0)
        newton = h - step
        inside = (newton > low) & (newton < high)
        new = np.where(inside, newton, 0.5 * (low + high))
        done = np.abs(new - h) <= 4e-16 * np.pi
        h = new
        if done.all():
            break
    return np.where(np.abs(h - _LARGEST_HALF) < 1e-14, _LARGEST_HALF, h)


def _slope(h: Array, rho: Array, z: Array, length: float) -> tuple[Array, Array]:
    """Return half the squared distance's first and second derivative by h."""
    c, dc = sinc(h), h * sinc_slope(h)
    ddc = -c - 2 * sinc_slope(h)  # from h sinc'' + 2 sinc' + h sinc = 0
    sin, cos = np.sin(h), np.cos(h)
    p = length * c * sin - rho, length * c * cos - z
    d = length * (dc * sin + c * cos), length * (dc * cos - c * sin)
    dd = length * (ddc * sin + 2 * dc * cos - c * sin), length * (ddc * cos - 2 * dc * sin - c * cos)
    return p[0] * d[0] + p[1] * d[1], d[0] ** 2 + d[1] ** 2 + p[0] * dd[0] + p[1] * dd[1]

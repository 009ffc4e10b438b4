"""Inverse kinematics: tip position to bend, and the dome of reachable tips.

A tip of the arc lies on the ray at polar angle h = bend_angle/2 from the straight arm, at
distance length * sinc(h). So bend = 2 atan2(rho, z) (x, y)/rho inverts the forward kinematics
exactly, and the reachable set is a surface of revolution (the *dome*), not a spherical
shell and not a volume: a position has three coordinates, the section two degrees of freedom. Every
solution therefore reports its *miss*, the distance from the target to the tip it reaches.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError, UnreachableError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import SINC, Array, as_floats, blocks, polynomial, sinc
from contarm_sim.kinematics.nearest import LARGEST_HALF, step_to_nearest
from contarm_sim.kinematics.search import search_nearest

Projection = Literal["refuse", "nearest", "ray", "paper"]
PROJECTIONS: tuple[Projection, ...] = get_args(Projection)

TOLERANCE = 3e-4
"""Miss below which a target counts as reached, as a fraction of length (0.11 mm for the paper's arm)."""

_AXIS = 1e-150  # nearer to the axis than this, squares underflow
_HUGE = 2.0**500  # brings such numbers to where squares do not
_NEAR = 1e-100  # lower than this on the axis is at the base [m]
_FARTHEST = 1e6  # lengths


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
    target = as_floats(target, 3, "target")
    tolerance = TOLERANCE * length if tolerance is None else tolerance
    if project == "nearest":
        bend, miss = _nearest(target, length)
    else:
        bend, miss = _solve(_paper if project == "paper" else _ray, target, length)
    reachable = np.asarray(miss <= tolerance)
    if project == "refuse" and not reachable.all():
        _accept_nearest(target, bend, miss, length, tolerance)
        reachable[...] = True
    return Reach(bend, miss, reachable)


def _solve(solver: Solver, target: Array, length: float) -> tuple[Array, Array]:
    """Solve for the bend and the miss of targets of any shape, block by block.

    Raises:
        InputError: a target is not finite, or too far away.
    """
    rows = target.reshape(-1, 3)
    bend, miss = np.empty((len(rows), 2)), np.empty(len(rows))
    farthest = _FARTHEST * length
    for block in blocks(len(rows)):
        part = rows[block]
        if not -farthest <= np.minimum.reduce(part, axis=None) <= np.maximum.reduce(part, axis=None) <= farthest:
            worst = part[~(np.abs(part) <= farthest).all(axis=-1)][0]
            raise InputError("target", worst.tolist(), f"finite, within {_FARTHEST:g} backbone lengths")
        miss[block] = solver(part[:, 0], part[:, 1], part[:, 2], length, bend[block])
    return bend.reshape(*target.shape[:-1], 2), miss.reshape(target.shape[:-1])


def _accept_nearest(target: Array, bend: Array, miss: Array, length: float, tolerance: float) -> None:
    """Put in the dome's nearest points for targets that their own rays miss; refuse those that are off the dome.

    Raises:
        UnreachableError: even the nearest point is farther than the tolerance; names the first such target.
    """
    off = ~(miss <= tolerance)
    bend[off], miss[off] = _nearest(target[off], length)
    if np.any(miss > tolerance):
        index = int(np.argmax(miss > tolerance))
        first, found = target.reshape(-1, 3)[index], bend.reshape(-1, 2)[index]
        raise UnreachableError(
            first, float(miss.reshape(-1)[index]), arc.position(found, length, check=False), tolerance, index
        )


# Each takes columns x, y, z of targets, shape (n,), fills in the bends, shape (n, 2), and returns the misses.
Solver = Callable[[Array, Array, Array, float, Array], Array]
Finder = Callable[[Array, Array], tuple[Array, Array]]


def _ray(x: Array, y: Array, z: Array, length: float, bend: Array) -> Array:
    """Keep the direction: the reached tip lies on the target's ray, so the miss is a difference of radii."""
    square = x * x + y * y
    rho = np.sqrt(square)
    half = np.arctan2(rho, z)
    below = np.flatnonzero(half > LARGEST_HALF)  # no bend below pi points there: the rim, or straight on the axis
    np.minimum(half, LARGEST_HALF, out=half)
    per_rho = 2 * half / np.maximum(rho, _AXIS)
    close = np.flatnonzero(rho < _AXIS)
    if close.size:
        per_rho[close] = 2 / np.where(z[close] > _NEAR, z[close], np.inf)
    np.multiply(per_rho, x, out=bend[:, 0])
    np.multiply(per_rho, y, out=bend[:, 1])
    miss = np.abs(np.sqrt(square + z * z) - length * polynomial(SINC, half * half))
    if below.size:
        miss[below] = _miss(x[below], y[below], z[below], length, bend[below])
    return miss


def _nearest(target: Array, length: float) -> tuple[Array, Array]:
    """Return (bend, miss) of the dome's nearest points: by few equal steps, the rare others by searching."""
    bend, miss = _solve(partial(_in_plane, step_to_nearest), target, length)
    rare = np.isnan(miss)
    if rare.any():
        bend[rare], miss[rare] = _solve(partial(_in_plane, search_nearest), target[rare], length)
    return bend, miss


def _in_plane(find: Finder, x: Array, y: Array, z: Array, length: float, bend: Array) -> Array:
    """Find the nearest point in the target's own half-plane; on the axis, the one towards muscle 1."""
    rho = np.sqrt(x * x + y * y)
    close = np.flatnonzero(rho < _AXIS)
    if close.size:
        along = _HUGE * np.stack([x[close], y[close]], axis=-1)
        far = np.hypot(along[:, 0], along[:, 1])
        rho[close] = far / _HUGE
        along[far == 0], far[far == 0] = (1.0, 0.0), 1.0
    half, distance = find(rho / length, z / length)
    per_rho = half / np.maximum(rho, _AXIS)
    per_rho *= 2.0
    np.multiply(per_rho, x, out=bend[:, 0])
    np.multiply(per_rho, y, out=bend[:, 1])
    if close.size:
        bend[close] = (2 * half[close] / far)[:, None] * along
    distance *= length
    return distance


def _paper(x: Array, y: Array, z: Array, length: float, bend: Array) -> Array:
    """Evaluate the paper's phi_IK (eq. 21) in the paper's plane.

    2 P_y/(F_1 F_2) equals 2 rho length/|P|^2 wherever it is not 0/0 (P_y = 0), which is how it is evaluated.
    """
    squared = x * x + y * y + z * z
    per_rho = np.divide(2 * length, squared, out=np.full_like(squared, np.inf), where=squared != 0)
    with np.errstate(invalid="ignore"):
        bend_angle = per_rho * np.hypot(x, y)
    if not np.all(bend_angle < np.pi):
        raise InputError("target", "where the paper's phi_IK is pi or more", "0 <= phi_IK < pi, or --project nearest")
    bend[:, 0], bend[:, 1] = per_rho * x, per_rho * y
    return _miss(x, y, z, length, bend)


def _miss(x: Array, y: Array, z: Array, length: float, bend: Array) -> Array:
    offset = arc.position(bend, length, check=False)
    offset -= np.stack([x, y, z], axis=-1)
    return np.asarray(np.linalg.norm(offset, axis=-1))

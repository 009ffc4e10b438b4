"""The nearest that three sections come to a pose, or to a position and direction, by damped least squares.

The best few of a fixed set of poses are the starts. The limits are an active set: a section at its limit that would
bend further only turns its plane. It finds a lowest miss nearby, which need not be the lowest of all.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.pose_newton import pose_and_jacobian
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH

_POOL, _STARTS, _STEPS, _BLOCK = 600, 6, 100, 512


def nearest(position: Array, rotation: Array, backbone: Backbone, *, roll: bool = True) -> Array:
    """Return bends within the limits [rad], shape (n, 3, 2), of the least miss known.

    Args:
        position: targets [m], shape (n, 3).
        rotation: targets, shape (n, 3, 3).
        backbone: three sections, no connectors.
        roll: whether the whole rotation counts; else only the direction of its last column.
    """
    out = np.empty((len(position), 3, 2))
    for start in range(0, len(position), _BLOCK):
        part = slice(start, start + _BLOCK)
        out[part] = _block(position[part], rotation[part], backbone, roll)
    return out


def _block(position: Array, rotation: Array, backbone: Backbone, roll: bool) -> Array:
    count = len(position)
    pool, p, R = _pool(backbone)
    far = np.sum(((position[:, None] - p) / backbone.length) ** 2, axis=-1)
    cosine = 0.5 * (rotation.reshape(count, 9) @ R.reshape(-1, 9).T - 1)
    if not roll:
        cosine = rotation[:, :, 2] @ R[:, :, 2].T
    apart = ANGLE_LENGTH * np.arccos(np.clip(cosine, -1.0, 1.0))
    near = np.argsort(far + apart * apart, axis=-1)[:, :_STARTS]
    bends, cost = _descended(
        np.repeat(position, _STARTS, axis=0), np.repeat(rotation, _STARTS, axis=0), pool[near.ravel()], backbone, roll
    )
    best = np.argmin(cost.reshape(count, _STARTS), axis=-1)
    return np.asarray(bends.reshape(count, _STARTS, 3, 2)[np.arange(count), best])


@lru_cache(maxsize=8)
def _pool(backbone: Backbone) -> tuple[Array, Array, Array]:
    """Return bends, positions and rotations of poses that are spread over the workspace; the straight one first."""
    rng = np.random.default_rng(0)
    angle = np.asarray(backbone.limits) * np.sqrt(rng.uniform(size=(_POOL, 3)))
    angle[0] = 0.0
    plane = rng.uniform(-np.pi, np.pi, (_POOL, 3))
    bends = angle[..., None] * np.stack([np.cos(plane), np.sin(plane)], axis=-1)
    p, R, _ = pose_and_jacobian(bends, backbone)
    return bends, p, R


def _descended(position: Array, rotation: Array, bends: Array, backbone: Backbone,
               roll: bool) -> tuple[Array, Array]:  # fmt: skip
    """Return bends of a locally least miss, and half its square."""
    limits = np.asarray(backbone.limits)
    best, damping, going = bends.copy(), np.full(len(bends), 1e-2), np.arange(len(bends))
    off, J = off_and_jacobian(position, rotation, best, backbone, roll)
    cost = 0.5 * np.sum(off * off, axis=-1)
    for _ in range(_STEPS):
        turn = _planes(best[going])
        steep = np.einsum("nik,nkj->nij", J, turn)
        slope = np.einsum("nij,ni->nj", steep, off)
        angle = np.hypot(best[going, :, 0], best[going, :, 1])
        held = (angle >= limits * (1 - 1e-12)) & (slope[:, ::2] < 0)
        steep[:, :, ::2] *= ~held[:, None, :]
        slope[:, ::2] *= ~held
        H = np.einsum("nij,nik->njk", steep, steep) + (damping[going, None, None] + 1e-15) * np.eye(6)
        step = np.einsum("njk,nk->nj", turn, np.linalg.solve(H, slope[..., None])[..., 0])
        tried = best[going] - step.reshape(-1, 3, 2)
        angle = np.hypot(tried[..., 0], tried[..., 1])
        tried *= np.minimum(1.0, limits / np.maximum(angle, 1e-300))[..., None]
        new_off, new_J = off_and_jacobian(position[going], rotation[going], tried, backbone, roll)
        new = 0.5 * np.sum(new_off * new_off, axis=-1)
        better = new < cost[going]
        gain = cost[going] - new
        damping[going] = np.where(better, 0.2 * damping[going], 5 * damping[going] + 1e-12)
        best[going[better]], cost[going[better]] = tried[better], new[better]
        off, J = np.where(better[:, None], new_off, off), np.where(better[:, None, None], new_J, J)
        on = (cost[going] > 1e-32) & (damping[going] < 1e8) & ~(better & (gain <= 1e-15 * cost[going]))
        if not on.any():
            break
        going, off, J = going[on], off[on], J[on]
    return best, cost


def _planes(bends: Array) -> Array:
    """Return the turn from (outwards, sideways) of each section to bend x and y, shape (n, 6, 6)."""
    angle = np.hypot(bends[..., 0], bends[..., 1])
    x = np.divide(bends[..., 0], angle, out=np.ones_like(angle), where=angle > 0)
    y = np.divide(bends[..., 1], angle, out=np.zeros_like(angle), where=angle > 0)
    out = np.zeros((len(bends), 6, 6))
    for k in range(3):
        out[:, 2 * k, 2 * k] = out[:, 2 * k + 1, 2 * k + 1] = x[:, k]
        out[:, 2 * k, 2 * k + 1], out[:, 2 * k + 1, 2 * k] = -y[:, k], y[:, k]
    return out


def off_and_jacobian(position: Array, rotation: Array, bends: Array, backbone: Backbone,
                     roll: bool) -> tuple[Array, Array]:  # fmt: skip
    """Return misses, shape (n, 6), and their Jacobian, shape (n, 6, 6), as fractions of the length.

    The distance, then the rotation vector from the target times 0.3, without its part along the tip unless `roll`. Half
    the square's gradient is exact, the Jacobian itself only near the target.
    """
    p, R, J = pose_and_jacobian(bends, backbone)
    off = np.empty((len(bends), 6))
    off[:, :3] = (p - position) / backbone.length
    J[:, :3] /= backbone.length
    if roll:
        turn = R @ rotation.swapaxes(-1, -2)
        axis = 0.5 * np.stack(
            [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], axis=-1
        )
        cosine = 0.5 * (turn[:, 0, 0] + turn[:, 1, 1] + turn[:, 2, 2] - 1)
    else:
        axis = np.cross(rotation[:, :, 2], R[:, :, 2])
        cosine = np.sum(rotation[:, :, 2] * R[:, :, 2], axis=-1)
        d = R[:, :, 2]
        J[:, 3:] -= d[:, :, None] * np.einsum("ni,nij->nj", d, J[:, 3:])[:, None, :]
    opposite = (cosine < 0) & (np.sum(axis * axis, axis=-1) < 1e-24)
    axis[opposite] = 1e-9 * R[opposite, :, 0]  # a half-turn: any axis across the tip's will do
    sine = np.sqrt(np.sum(axis * axis, axis=-1))
    scale = np.divide(np.arctan2(sine, cosine), sine, out=np.ones_like(sine), where=sine > 0)
    off[:, 3:] = ANGLE_LENGTH * scale[:, None] * axis
    J[:, 3:] *= ANGLE_LENGTH
    return off, J

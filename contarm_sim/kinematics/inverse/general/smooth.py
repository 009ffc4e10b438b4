"""What each choice makes least, made smooth: value, slopes and curvature, as Newton's method wants them.

With bend angles a_k, and a width m [rad] that goes to 0:

    nearest         half the square of the distance
    least-bend      sum of s_k, s_k = sqrt(a_k^2 + m^2)
    least-largest   m log(sum of exp(a_k/m)), at most m log(S) above the largest
    farthest        the same of a_k - limit_k

and (a_k - limit_k)^2/(2 m) of every bend angle beyond its limit. The curvature of least-bend is that of
E. Andersen, A. Christiansen, A. Conn and M. Overton, "An efficient primal-dual interior-point method for minimizing a
sum of Euclidean norms", SIAM J. Sci. Comput. 22, 2000: with it, one step leads to a straight section from afar.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import Choice
from contarm_sim.kinematics.inverse.limits import angles_of

_MARGIN = 2e-6  # bends stay this far inside their limits [rad]: what the width lets through
_MOST = 0.999  # of a dual vector's length, 1 where a section is bent


def value(bends: Array, backbone: Backbone, choose: Choice, near: Array | None, width: Array) -> Array:
    """Return what is made least, shape (n,), of bends [rad], shape (n, S, 2), and widths [rad], shape (n,)."""
    angles, m = angles_of(bends), width[:, None]
    beyond = np.maximum(angles - _inside(backbone), 0.0)
    return np.asarray(_value(bends, angles, backbone, choose, near, m) + (0.5 * beyond**2 / m).sum(axis=-1))


def slopes(bends: Array, backbone: Backbone, choose: Choice, near: Array | None, width: Array) -> Array:
    """Return how it grows by the bends, shape (n, S, 2)."""
    angles, m = angles_of(bends), width[:, None]
    axis = bends / np.maximum(angles, 1e-300)[..., None]
    beyond = np.maximum(angles - _inside(backbone), 0.0)
    if choose == "nearest":
        own = bends - np.asarray(near)
    elif choose == "least-bend":
        own = bends / np.hypot(angles, m)[..., None]
    else:
        own = _shares(angles, backbone, choose, m)[..., None] * axis
    return np.asarray(own + (beyond / m)[..., None] * axis)


def curvature(bends: Array, backbone: Backbone, choose: Choice, width: Array, dual: Array) -> Array:
    """Return its second derivatives, shape (n, S, 2, S, 2); `dual`: the forces that hold tips, as bends, (n, S, 2)."""
    count, size = bends.shape[:2]
    angles, m = angles_of(bends), width[:, None]
    safe = np.maximum(angles, 1e-9)
    axis = bends / np.maximum(angles, 1e-300)[..., None]
    along = axis[..., :, None] * axis[..., None, :]
    across = np.eye(2) - along
    out = np.zeros((count, size, 2, size, 2))
    if choose == "nearest":
        blocks = np.broadcast_to(np.eye(2), along.shape)
    elif choose == "least-bend":
        s = np.hypot(angles, m)
        y = dual * np.minimum(1.0, _MOST / np.maximum(angles_of(dual), 1e-300))[..., None]
        both = y[..., :, None] * bends[..., None, :]
        blocks = (np.eye(2) - 0.5 * (both + both.swapaxes(-1, -2)) / s[..., None, None]) / s[..., None, None]
    else:
        share = _shares(angles, backbone, choose, m)
        blocks = (share / safe)[..., None, None] * across + (share / m)[..., None, None] * along
        pull = share[..., None] * axis
        out -= pull[:, :, :, None, None] * pull[:, None, None, :, :] / m[..., None, None, None]
    beyond = np.maximum(angles - _inside(backbone), 0.0)
    blocks = blocks + ((beyond > 0) / m)[..., None, None] * along + (beyond / (m * safe))[..., None, None] * across
    own = np.arange(size)
    out[:, own, :, own, :] += blocks.swapaxes(0, 1)
    return out


def _value(bends: Array, angles: Array, backbone: Backbone, choose: Choice, near: Array | None, m: Array) -> Array:
    if choose == "nearest":
        return np.asarray(0.5 * ((bends - np.asarray(near)) ** 2).sum(axis=(-1, -2)))
    if choose == "least-bend":
        return np.asarray(np.hypot(angles, m).sum(axis=-1))
    large = angles - np.array(backbone.limits) if choose == "farthest" else angles
    top = large.max(axis=-1)
    return np.asarray(top + m[:, 0] * np.log(np.exp((large - top[:, None]) / m).sum(axis=-1)))


def _shares(angles: Array, backbone: Backbone, choose: Choice, m: Array) -> Array:
    """Return what each section adds to the largest, 1 in all, shape (n, S)."""
    large = angles - np.array(backbone.limits) if choose == "farthest" else angles
    share = np.exp((large - large.max(axis=-1, keepdims=True)) / m)
    return np.asarray(share / share.sum(axis=-1, keepdims=True))


def _inside(backbone: Backbone) -> Array:
    return np.array(backbone.limits) - _MARGIN

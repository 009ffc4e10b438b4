"""The two solutions of a pose that is close to the straight arm's, from what bends do to second order.

To first order, position and direction of the tip are linear in the bends and leave one plane vector n free, along the
combination of sections that moves neither. What n does to the height is a circle, what it does to the roll a line.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone

NEAR = 2e-3
"""How much shorter than the arm, as a fraction, the tip's distance may be for a pose to count as nearly straight."""


def nearly_straight(position: Array, rotation: Array, backbone: Backbone) -> Array:
    """Return two starts for each pose [rad], shape (2, n, 3, 2), good to a fraction of about |bend|^2.

    Args:
        position: of the end of section 3 [m], shape (n, 3).
        rotation: of the end, shape (n, 3, 3).
        backbone: three sections.
    """
    lengths = np.asarray(backbone.lengths)
    tip = np.stack([rotation[:, 0, 2] - rotation[:, 2, 0], rotation[:, 1, 2] - rotation[:, 2, 1]], axis=-1) / 2
    roll = (rotation[:, 1, 0] - rotation[:, 0, 1]) / 2
    moved = np.stack([np.ones(3), 0.5 * lengths + sum(lengths) - np.cumsum(lengths)])
    given = np.linalg.pinv(moved) @ np.stack([tip, position[:, :2]], axis=1)
    free = np.cross(moved[0], moved[1] / sum(lengths))
    height = _shortening(backbone)
    a, b = free @ height @ free, np.einsum("k,nkx->nx", height @ free, given)
    c = np.einsum("nkx,kj,njx->n", given, height, given) - 2 * (sum(lengths) - position[:, 2])
    # Twice the roll is the sum of cross products of earlier with later bends.
    g, twist = np.zeros_like(tip), 2 * roll
    for j, k in ((0, 1), (0, 2), (1, 2)):
        g = g + free[k] * given[:, j] - free[j] * given[:, k]
        twist = twist - (given[:, j, 0] * given[:, k, 1] - given[:, j, 1] * given[:, k, 0])
    size = np.hypot(g[:, 0], g[:, 1])
    axis = np.where(size[:, None] > 0, g, [1.0, 0.0]) / np.where(size > 0, size, 1.0)[:, None]
    across = np.stack([-axis[:, 1], axis[:, 0]], axis=-1)
    off = np.divide(twist, size, out=np.zeros_like(size), where=size > 0)
    middle = -np.sum(b * axis, axis=-1) / a
    rest = middle**2 - (a * off**2 + 2 * off * np.sum(b * across, axis=-1) + c) / a
    apart = np.sqrt(np.maximum(rest, 0.0))
    n = np.stack([middle + apart, middle - apart])[..., None] * axis + off[:, None] * across
    return np.asarray(given + free[:, None] * n[:, :, None, :])


def _shortening(backbone: Backbone) -> Array:
    """Return the matrix M [m] of 2 (length - height) = sum of M_jk bend_j . bend_k, to second order, shape (3, 3)."""
    M = np.zeros((3, 3))
    for k, length in enumerate(backbone.lengths):
        before = np.eye(3)[:k].sum(axis=0)
        own = np.eye(3)[k]
        links = np.inf if backbone.links is None else backbone.links[k]
        M += length * (np.outer(before, before) + 0.5 * (np.outer(before, own) + np.outer(own, before)))
        M += length * (1 / 3 + 1 / (6 * links**2)) * np.outer(own, own)
    return M

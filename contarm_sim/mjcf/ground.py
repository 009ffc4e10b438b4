"""Planes in pictures: the one that is the floor, and the part of the others that is drawn, for planes have no end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contarm_sim.mjcf.surfaces import turned

if TYPE_CHECKING:
    from contarm_sim.model.arm import Arm
    from contarm_sim.model.objects import Object

_LEVEL = np.cos(np.radians(0.5))
"""Part upwards of the normal of a plane that is the floor."""

_SIDE, _LOWEST = 0.8, 1.6
"""How far a plane is drawn to its sides, and down to the floor at most [lengths]."""


def floor_plane(arm: Arm, turn: np.ndarray) -> Object | None:
    """Return the level plane that is the floor of the scene, the highest of several; or None.

    Args:
        turn: of the base frame into the scene's, shape (3, 3).
    """
    level = [one for one in arm.world.objects if one.shape == "plane" and (turn @ turned(one))[2, 2] > _LEVEL]
    return max(level, key=lambda one: float(turn[2] @ one.position), default=None)


def patch(each: Object, arm: Arm, turn: np.ndarray, ground: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the part of a plane that is drawn: a rectangle beside the arm that stands on the floor if it can.

    Args:
        turn: of the base frame into the scene's, shape (3, 3).
        ground: height of the floor above the base [m].

    Returns:
        its middle in the base frame [m], shape (3,); its axes there as columns, the last the normal, shape (3, 3); its
        half sides along the first two [m], shape (2,).
    """
    normal, length = turned(each)[:, 2], arm.length
    middle = np.array([0.0, 0.0, 0.5 * length])
    middle = middle - normal * (normal @ (middle - each.position))
    up = turn[2] - normal * (normal @ turn[2])
    if np.linalg.norm(up) < 0.1:
        up = turned(each)[:, 1]
    up = up / np.linalg.norm(up)
    low, high, rise = -_SIDE * length, _SIDE * length, float(turn[2] @ up)
    if rise > 0.1:
        low = float(np.clip((ground - turn[2] @ middle) / rise, -_LOWEST * length, -0.3 * length))
    axes = np.stack([np.cross(up, normal), up, normal], axis=1)
    return middle + 0.5 * (low + high) * up, axes, np.array([_SIDE * length, 0.5 * (high - low)])

"""The objects that a camera shows: those near the arm, whole where they end near it, else as far as they are near."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

_NEAR, _WAY, _WHOLE = 0.25, 0.6, 1.0
"""How far beyond all else what is fixed, and what moves, is shown [lengths]; all of what is nowhere farther than the
last."""


def with_objects(points: Array, arm: Arm, poses: Array | None = None) -> Array:
    """Return points of the base frame [m], shape (T, 3), and such as let a camera show what is near them too.

    Args:
        poses: of the F free objects at some moments, see `Trajectory.objects`, shape (K, F, 7); default where they
            begin.
    """
    from contarm_sim.mjcf.surfaces import surface, turned

    low, high, found, free = points.min(axis=0), points.max(axis=0), [points], 0
    for each in arm.world.objects:
        if each.shape == "plane":
            continue
        corners, most = _corners(surface(each)[0]), _NEAR
        if each.free and poses is not None:
            corners, most = _moved(corners, poses[:, free]), _WAY
        else:
            corners = corners @ turned(each).T + each.position
        free += each.free
        room = most * arm.length
        whole = _WHOLE * arm.length
        if np.all(corners.max(axis=0) <= high + whole) and np.all(corners.min(axis=0) >= low - whole):
            found.append(corners)
        elif np.all(corners.min(axis=0) <= high + room) and np.all(corners.max(axis=0) >= low - room):
            found.append(corners.clip(low - room, high + room))
    return np.vstack(found)


def _corners(vertices: Array) -> Array:
    """Return the corners of the box about some vertices, shape (8, 3)."""
    ends = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
    return np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def _moved(corners: Array, poses: Array) -> Array:
    """Return the corners at all poses [m], shape (8 K, 3)."""
    import mujoco

    turns = np.zeros((len(poses), 9))
    for turn, pose in zip(turns, poses, strict=True):
        mujoco.mju_quat2Mat(turn, pose[3:])
    return np.asarray((corners @ turns.reshape(-1, 3, 3).swapaxes(1, 2) + poses[:, None, :3]).reshape(-1, 3))

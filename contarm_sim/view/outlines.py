"""The objects of an arm's world where figures have them: surfaces in the base frame, at a moment of a motion."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.rotations import rotation_from_quaternion
from contarm_sim.mjcf.ground import floor_plane, patch
from contarm_sim.mjcf.scene import base_position, base_rotation
from contarm_sim.mjcf.surfaces import surface, turned
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import Object
from contarm_sim.results.trajectory import Trajectory

Placed = tuple[Object, Array, NDArray[np.intp]]
"""An object, its vertices in the base frame [m], shape (K, 3), and its triangles, shape (F, 3)."""


def placed_objects(arm: Arm, poses: Array | None = None) -> Iterator[Placed]:
    """Return what an arm can touch, one by one; of planes the part beside the arm.

    Args:
        poses: of the free objects, see `Trajectory.objects`, shape (F, 7); default where they begin.
    """
    turn, ground, free = base_rotation(arm), -float(base_position(arm)[2]), 0
    floor = floor_plane(arm, turn)
    for each in arm.world.objects:
        if each.shape == "plane":
            middle, axes, sides = patch(each, arm, turn, ground)
            sides = np.full(2, arm.length) if each is floor else sides
            corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * sides
            yield each, middle + corners @ axes[:, :2].T, np.array([[0, 1, 2], [0, 2, 3]])
            continue
        vertices, faces = surface(each)
        rotation, place = turned(each), np.array(each.position)
        if each.free:
            if poses is not None:
                rotation, place = rotation_from_quaternion(poses[free, 3:]), poses[free, :3]
            free += 1
        yield each, vertices @ rotation.T + place, faces


def poses_at(samples: Trajectory, index: int) -> Array | None:
    """Return where the free objects are in a sample, if that was recorded."""
    return None if samples.objects is None else samples.objects[index]

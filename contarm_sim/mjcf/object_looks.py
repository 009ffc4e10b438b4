"""How objects look in the scene: matte, and planes, which have no end, as a part of them beside the arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from contarm_sim.mjcf.ground import floor_plane, patch
from contarm_sim.mjcf.objects import geom_size
from contarm_sim.mjcf.scene import base_position, base_quaternion, base_rotation
from contarm_sim.mjcf.surfaces import turned

if TYPE_CHECKING:
    from contarm_sim.model.arm import Arm

MATERIAL, WALL = "object", "wall"
"""What objects are made of in pictures, and planes that are not the floor; their colours are their own."""

_PLAIN = (0.5, 0.5, 0.5)
"""Colour of a geom that the engine takes for none."""


def dress_objects(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Give the objects of a scene their looks; after `place_objects`."""
    if not arm.world.objects:
        return
    for name, glow in ((MATERIAL, 0.0), (WALL, 0.3)):
        spec.add_material(name=name, rgba=[*_PLAIN, 1.0], specular=0.12, shininess=0.15, emission=glow)
    turn, ground = base_rotation(arm), -float(base_position(arm)[2])
    floor = floor_plane(arm, turn)
    for each in arm.world.objects:
        geom = spec.geom(each.name)
        geom.material = WALL if each.shape == "plane" else MATERIAL
        if each is floor:  # the scene's own floor is drawn in its place
            geom.rgba[3] = 0.0
        elif each.shape == "plane":
            middle, axes, sides = patch(each, arm, turn, ground)
            own = turned(each)
            geom.pos = own.T @ (middle - each.position)
            mujoco.mju_mat2Quat(geom.quat, np.ascontiguousarray(own.T @ axes).ravel())
            geom.size[:2] = sides


def restage(model: mujoco.MjModel, drawn: Arm, arm: Arm) -> None:
    """Give the objects of a compiled scene the sizes and places that those of another arm have; planes stay.

    Args:
        drawn: the arm of the scene.
        arm: one with the same objects.
    """
    for each in arm.world.objects:
        if each.shape == "plane":
            continue
        pose = to_scene(drawn, np.array([[*each.position, *each.quaternion]]))
        body = model.body(each.name)
        body.pos, body.quat = pose[:3], pose[3:]
        if each.shape != "mesh":
            model.geom(each.name).size[:] = geom_size(each)


def to_scene(arm: Arm, poses: np.ndarray, body: Any = None) -> np.ndarray:
    """Return positions and orientations of free objects as joints of the scene have them.

    Args:
        poses: in the base frame, position [m] and quaternion w x y z, shape (F, 7).
        body: the engine's view of the base where a host has moved it.

    Returns:
        likewise in the scene, shape (7 F,).
    """
    base, quat, turn = base_position(arm), base_quaternion(arm), base_rotation(arm)
    if body is not None:
        base, quat, turn = body.xpos, body.xquat, body.xmat.reshape(3, 3)
    out = np.array(poses, dtype=float)
    out[:, :3] = base + out[:, :3] @ turn.T
    for row, given in zip(out, np.asarray(poses), strict=True):
        mujoco.mju_mulQuat(row[3:], quat, given[3:])
    return out.ravel()

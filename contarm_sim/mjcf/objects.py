"""What the arm can touch, as MjSpec elements: bodies of their own, in the arm's base frame."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.mjcf.contact import LINKS, soften
from contarm_sim.mjcf.meshes import check_mesh
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import Object, said_of_object

_KIND = mujoco.mjtGeom
GEOMS = {
    "box": _KIND.mjGEOM_BOX, "sphere": _KIND.mjGEOM_SPHERE, "capsule": _KIND.mjGEOM_CAPSULE,
    "cylinder": _KIND.mjGEOM_CYLINDER, "plane": _KIND.mjGEOM_PLANE, "mesh": _KIND.mjGEOM_MESH,
}  # fmt: skip

OF_OBJECTS = ("bodies", "geoms", "joints", "meshes")
"""Parts of a spec that an object's name may be given to. Of two joints of one name the engine silently drops one's."""


def geom_size(each: Object) -> list[float]:
    """Return the size of an object's geom as the engine has it: half edges, radius and half length."""
    if each.size is not None:
        return [0.5 * edge for edge in each.size]
    if each.shape == "plane":
        return [0.0, 0.0, 0.05]
    return [each.radius or 0.0, 0.5 * (each.length or 0.0), 0.0]


def add_objects(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Add the objects of an arm's world, whose base is at the spec's origin.

    Raises:
        InputError: a name that the arm has, or a mesh that cannot be read.
    """
    taken = {part.name for kind in OF_OBJECTS for part in getattr(spec, kind)}
    for each in arm.world.objects:
        if each.name in taken:
            allowed = "another: parts of the arm have it, or of its world"
            raise InputError("name", repr(each.name), allowed, said_of_object(each.name))
        body = spec.worldbody.add_body(name=each.name, pos=each.position, quat=each.quaternion)
        if each.free:
            body.add_freejoint(name=each.name)
        _add_geom(spec, body, each, arm)


def _add_geom(spec: mujoco.MjSpec, body: mujoco.MjsBody, each: Object, arm: Arm) -> None:
    more: dict[str, Any]
    if each.file is not None:
        check_mesh(each, arm)
        spec.add_mesh(name=each.name, file=str(Path(each.file).resolve()), scale=[each.scale] * 3)
        more = {"meshname": each.name}
    else:
        more = {"size": geom_size(each)}
    if each.mass is not None:
        more["mass"] = each.mass
    geom = body.add_geom(
        name=each.name, type=GEOMS[each.shape], rgba=[*each.colour, 1.0], contype=LINKS, conaffinity=LINKS,
        friction=[each.friction, 0.005, 0.0001], priority=2 if each.free else 1, **more,
    )  # fmt: skip
    soften(geom, each.free)


def place_objects(spec: mujoco.MjSpec, arm: Arm, position: np.ndarray, quat: np.ndarray) -> None:
    """Move the objects with a base that is not at the spec's origin.

    Args:
        position, quat: of the base: [m], and w x y z.
    """
    for each in arm.world.objects:
        body, moved, turned = spec.body(each.name), np.zeros(3), np.zeros(4)
        mujoco.mju_rotVecQuat(moved, np.array(each.position), quat)
        mujoco.mju_mulQuat(turned, quat, np.array(each.quaternion))
        body.pos, body.quat = position + moved, turned

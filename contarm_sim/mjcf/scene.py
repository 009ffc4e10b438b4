"""What surrounds the arm in a picture: floor, mount, light, cameras, and which way is down."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.mjcf.backbone import disk_radius

OFFSCREEN = (1920, 1080)
"""Largest picture [pixels] that the model's offscreen buffer holds."""


def base_quaternion(arm: Arm) -> np.ndarray:
    """Return the base's orientation in the world, quaternion w x y z.

    Unless the arm states it, the smallest turn that makes gravity point down (-Z of the world).
    """
    if arm.base_orientation is not None:
        return np.array(arm.base_orientation)
    down = np.array(arm.gravity)
    if not down.any():
        return np.array([1.0, 0.0, 0.0, 0.0])
    down = down / np.linalg.norm(down)
    w = 1.0 - down[2]
    if w < 1e-9:  # hanging: half a turn about X
        return np.array([0.0, 1.0, 0.0, 0.0])
    quaternion = np.array([w, *np.cross(down, [0.0, 0.0, -1.0])])
    return quaternion / np.linalg.norm(quaternion)


def world_gravity(arm: Arm) -> np.ndarray:
    """Return the arm's gravity [m/s^2] in the world frame of the scene."""
    gravity = np.zeros(3)
    mujoco.mju_rotVecQuat(gravity, np.array(arm.gravity), base_quaternion(arm))
    return gravity


def add_scene(spec: mujoco.MjSpec, arm: Arm) -> np.ndarray:
    """Add floor, mount, light and cameras; return where the base goes in the world [m]."""
    length, quaternion = arm.length, base_quaternion(arm)
    along = np.zeros(3)
    mujoco.mju_rotVecQuat(along, np.array([0.0, 0.0, 1.0]), quaternion)
    height = length * (0.22 if along[2] > 0.5 else 1.3)  # room for the arm to bend below its base
    base = np.array([0.0, 0.0, height])
    centre = base + 0.45 * length * along

    spec.visual.global_.offwidth, spec.visual.global_.offheight = OFFSCREEN
    spec.visual.headlight.ambient = [0.35, 0.35, 0.35]
    spec.visual.headlight.diffuse = [0.35, 0.35, 0.35]
    spec.visual.headlight.specular = [0.1, 0.1, 0.1]
    spec.visual.quality.shadowsize = 2048
    spec.visual.map.znear = 0.01
    spec.visual.map.zfar = 30
    spec.stat.extent = 1.2 * length
    spec.stat.center = centre

    texture, kind = mujoco.mjtTexture, mujoco.mjtBuiltin
    spec.add_texture(
        name="sky", type=texture.mjTEXTURE_SKYBOX, builtin=kind.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.95, 0.97], rgb2=[0.70, 0.76, 0.83], width=64, height=384,
    )  # fmt: skip
    spec.add_texture(
        name="floor", type=texture.mjTEXTURE_2D, builtin=kind.mjBUILTIN_CHECKER, width=256, height=256,
        rgb1=[0.86, 0.88, 0.90], rgb2=[0.80, 0.82, 0.85], mark=mujoco.mjtMark.mjMARK_EDGE, markrgb=[0.93, 0.94, 0.95],
    )  # fmt: skip
    floor = spec.add_material(name="floor", texuniform=True, texrepeat=[5, 5])
    floor.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    mount = spec.add_material(name="mount", rgba=[0.34, 0.37, 0.41, 1], specular=0.4, shininess=0.4)

    world = spec.worldbody
    world.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], material="floor")
    world.add_light(
        name="key", pos=centre + np.array([-1.0, -1.2, 2.2]) * length * 2, dir=[1.0, 1.2, -2.2],
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, diffuse=[0.55, 0.55, 0.55], castshadow=True,
    )  # fmt: skip
    radius = disk_radius(arm)
    back = max(0.1 * length, height) if along[2] > 0.99 else 0.3 * length
    world.add_geom(
        name="mount", type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[0.62 * radius, 0, 0], material=mount.name,
        fromto=[*base, *(base - back * along)], contype=0, conaffinity=0,
    )  # fmt: skip
    world.add_geom(
        name="flange", type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[1.25 * radius, 0, 0], material=mount.name,
        fromto=[*(base - 0.002 * along), *(base - 0.012 * along)], contype=0, conaffinity=0,
    )  # fmt: skip
    _add_camera(spec, "front", centre, length, azimuth=-62, elevation=16, distance=2.9)
    _add_camera(spec, "side", centre, length, azimuth=0, elevation=4, distance=2.9)
    _add_camera(spec, "top", centre, length, azimuth=-90, elevation=89, distance=3.0)
    return base


def _add_camera(
    spec: mujoco.MjSpec, name: str, target: np.ndarray, length: float, azimuth: float, elevation: float, distance: float
) -> None:
    """Add a fixed camera that looks at `target` from the given angles [deg] and distance [lengths]."""
    a, e = math.radians(azimuth), math.radians(elevation)
    back = np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])
    right = np.array([-math.sin(a), math.cos(a), 0.0])
    camera = spec.worldbody.add_camera(name=name, pos=target + distance * length * back, fovy=35)
    camera.alt.xyaxes = [*right, *np.cross(back, right)]

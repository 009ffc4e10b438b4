"""What surrounds the arm in a picture: floor, mount, light, cameras, and which way is down."""

from __future__ import annotations

import math
from collections.abc import Iterable

import mujoco
import numpy as np

from contarm_sim.mjcf.framing import FOVY, Frame, axes, place
from contarm_sim.mjcf.ground import floor_plane
from contarm_sim.mjcf.outline import outline
from contarm_sim.mjcf.surfaces import placed_surface
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import Object

OFFSCREEN = (1920, 1080)
"""Largest picture [pixels] that the model's offscreen buffer holds."""

CLEARANCE = 0.15
"""Distance from the floor to the lowest point that the arm can touch [lengths]."""

_OUTLINE = ((0.0, 1.0), (0.32, 0.94), (0.56, 0.78), (0.69, 0.53), (0.73, 0.31), (0.64, 0.0))
"""Radius and height of a surface of revolution around all centrelines bent by up to half a turn [lengths]."""

HORIZON = (0.93, 0.945, 0.96)
FLOOR = (0.76, 0.785, 0.81)
LINES = (0.66, 0.69, 0.73)
_HAZE = 0.5
"""Colours of sky and floor and of the lines on it, and the share of the distance drawn that haze takes."""

CLEAR = 1 - _HAZE
"""Share of the distance drawn up to which haze leaves a thing clear."""

_LIGHTER = {"disk": (0.64, 0.67, 0.71), "plate": (0.33, 0.35, 0.39), "spine": (0.86, 0.87, 0.89)}
"""Materials of the arm as they are lit here: dark disks would hide each other."""

KEY = (-0.6, 0.5, -2.0)
"""Direction of the light that casts shadows."""

CAMERAS = {"front": (-62.0, 14.0), "side": (0.0, 6.0), "top": (-90.0, 89.0)}
"""Azimuth and elevation of the cameras [deg]."""


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


def base_rotation(arm: Arm) -> np.ndarray:
    """Return the rotation that turns vectors of the base frame into the world, shape (3, 3)."""
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, base_quaternion(arm))
    return rotation.reshape(3, 3)


def world_gravity(arm: Arm) -> np.ndarray:
    """Return the arm's gravity [m/s^2] in the world frame of the scene."""
    return base_rotation(arm) @ arm.gravity


def line_spacing(arm: Arm) -> float:
    """Return the distance between the lines on the floor [m]: a 1, 2 or 5, at most a third of the arm's length."""
    power = 10.0 ** math.floor(math.log10(arm.length / 3))
    return power * max(step for step in (1, 2, 5) if step * power <= arm.length / 3 * (1 + 1e-9))


def base_position(arm: Arm) -> np.ndarray:
    """Return where the base is in the world [m]: above the floor by what the arm can reach down to.

    A level plane that it can touch is the floor. Objects that go deeper than the arm can
    stand on the floor, unless they lie deeper by more than the arm's length. In a host it is where that says.
    """
    if arm.world.host is not None:
        return np.array(arm.world.host.base.position)
    turn = base_rotation(arm)
    floor = floor_plane(arm, turn)
    if floor is not None:
        return np.array([0.0, 0.0, -float(turn[2] @ floor.position)])
    reached = -arm.length * float(_outlined(arm)[:, 2].min())
    high = reached + CLEARANCE * arm.length
    ends = (placed_surface(each) for each in arm.world.objects if each.shape != "plane")
    deepest = max((-float((points @ turn[2]).min()) for points in ends), default=high)
    return np.array([0.0, 0.0, deepest if reached < deepest < high + arm.length else high])


def floor_colour(arm: Arm) -> tuple[float, ...]:
    """Return the colour of the floor: that of the level plane that it is, if this has one of its own."""
    floor = floor_plane(arm, base_rotation(arm))
    return FLOOR if floor is None or floor.colour == Object.colour else floor.colour


def part_name(spec: mujoco.MjSpec, name: str) -> str:
    """Return the name that a part of the scene goes by: another than its own where an object has that."""
    return f"scene/{name}" if spec.body(name) is not None else name


def workspace(arm: Arm) -> np.ndarray:
    """Return points of the world about all that an arm can touch, and its foot [m], shape (T, 3)."""
    base = base_position(arm)
    if arm.world.host is not None:
        return base + arm.length * _outlined(arm)
    return np.vstack([base + arm.length * _outlined(arm), [0.0, 0.0, max(0.0, base[2] - 0.4 * arm.length)]])


def add_scene(spec: mujoco.MjSpec, arm: Arm) -> np.ndarray:
    """Add floor, mount, light and cameras; return where the base goes in the world [m]."""
    length, base, seen = arm.length, base_position(arm), workspace(arm)
    along = base_rotation(arm)[:, 2]
    spec.visual.global_.offwidth, spec.visual.global_.offheight = OFFSCREEN
    spec.visual.map.znear = 0.01
    spec.visual.map.shadowclip = 4.0  # wide: towards its edge the shadow map stains the floor, which haze hides
    spec.stat.extent = 1.2 * length
    spec.stat.center = base + 0.45 * length * along
    lighten(spec)
    _add_surroundings(spec, arm)
    _add_lights(spec, spec.stat.center, length)
    _add_mount(spec, arm, base, along)
    depth = max(_add_camera(spec, name, seen, *angles) for name, angles in CAMERAS.items())
    spec.visual.map.zfar = max(8.0, math.ceil(depth / (CLEAR * spec.stat.extent)))
    return base


def add_to_host(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Add what a host lacks to be filmed: a large buffer, cameras, and a light."""
    lighten(spec)
    buffer, seen = spec.visual.global_, workspace(arm)
    buffer.offwidth, buffer.offheight = max(buffer.offwidth, OFFSCREEN[0]), max(buffer.offheight, OFFSCREEN[1])
    taken = {camera.name for camera in spec.cameras}
    for name, angles in CAMERAS.items():
        if name not in taken:
            _add_camera(spec, name, seen, *angles)
    if not len(spec.lights):
        _add_lights(spec, seen.mean(axis=0), arm.length)


def lighten(spec: mujoco.MjSpec) -> None:
    """Give an arm, if there is one, the colours that it has under the light of the scene."""
    for name, tone in _LIGHTER.items():
        material = spec.material(name)
        if material is not None:
            material.rgba[:3] = tone


def _outlined(arm: Arm) -> np.ndarray:
    """Return points around all that an arm can touch, relative to the base [lengths], shape (T, 3)."""
    along = base_rotation(arm)[:, 2]
    return _reach(along, arm.disk_radius / arm.length, _OUTLINE if len(arm.sections) == 1 else outline(arm))


def _reach(along: np.ndarray, thickness: float, outline: Iterable[tuple[float, float]]) -> np.ndarray:
    """Return points around all that an arm of a radius can touch, relative to the base [lengths], shape (T, 3)."""
    side = np.cross(along, [0.0, 1.0, 0.0] if abs(along[1]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    turn = np.linspace(0, 2 * math.pi, 24, endpoint=False)[:, None]
    ring = np.cos(turn) * side + np.sin(turn) * np.cross(along, side)
    wider = [(radius + thickness, height) for radius, height in outline]
    longer = [(radius, height + math.copysign(thickness, height - 0.1)) for radius, height in outline]
    return np.vstack([radius * ring + height * along for radius, height in wider + longer])


def _add_surroundings(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Add a floor that fades into a pale sky."""
    texture, kind = mujoco.mjtTexture, mujoco.mjtBuiltin
    spec.visual.rgba.haze = [*HORIZON, 1.0]
    spec.visual.map.haze = _HAZE
    spec.add_texture(
        name="sky", type=texture.mjTEXTURE_SKYBOX, builtin=kind.mjBUILTIN_GRADIENT,
        rgb1=[0.72, 0.80, 0.89], rgb2=HORIZON, width=64, height=384,
    )  # fmt: skip
    spec.add_texture(
        name="floor", type=texture.mjTEXTURE_2D, builtin=kind.mjBUILTIN_FLAT, width=512, height=512,
        rgb1=floor_colour(arm), rgb2=floor_colour(arm), mark=mujoco.mjtMark.mjMARK_EDGE, markrgb=LINES,
    )  # fmt: skip
    each = 1 / line_spacing(arm)
    floor = spec.add_material(name="floor", texuniform=True, texrepeat=[each, each], specular=0.0)
    floor.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    touched = 0 if arm.world.touchable else 1  # what is simulated has objects only
    spec.worldbody.add_geom(
        name=part_name(spec, "floor"), type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], material="floor",
        contype=touched, conaffinity=touched,
    )  # fmt: skip


def _add_lights(spec: mujoco.MjSpec, centre: np.ndarray, length: float) -> None:
    """Add a key light with shadow from the right, weak ones from the left and from the floor, and the camera's."""
    spec.visual.headlight.ambient = [0.36, 0.36, 0.37]
    spec.visual.headlight.diffuse = [0.16, 0.16, 0.16]
    spec.visual.headlight.specular = [0.05, 0.05, 0.05]
    spec.visual.quality.shadowsize = 4096
    for name, towards, tone, shadow in (
        ("key", KEY, (0.50, 0.49, 0.47), True),
        ("fill", (1.2, 0.9, -1.0), (0.20, 0.21, 0.23), False),
        ("floor", (0.2, 0.5, 1.0), (0.30, 0.30, 0.31), False),
    ):
        direction = np.array(towards) / np.linalg.norm(towards)
        spec.worldbody.add_light(
            name=name, pos=centre - 3 * length * direction, dir=direction, castshadow=shadow,
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, diffuse=tone, specular=[0.5 * part for part in tone],
        )  # fmt: skip


def _add_mount(spec: mujoco.MjSpec, arm: Arm, base: np.ndarray, along: np.ndarray) -> None:
    """Add a flange behind the base plate on a column from the floor, or from above if the arm points down."""
    spec.add_material(name="mount", rgba=[0.47, 0.50, 0.54, 1], specular=0.3, shininess=0.4)
    radius, length, up = arm.disk_radius, arm.length, np.array([0.0, 0.0, 1.0])
    elbow = base - 0.1 * length * along
    stands = along[2] > -0.1
    if stands and elbow[2] > 0.05 * length:
        _add_rod(spec, "foot", 1.7 * radius, np.zeros(3), up, 0.02 * length)
    _add_rod(spec, "flange", 1.2 * radius, base - 0.005 * length * along, -along, 0.022 * length)
    _add_rod(spec, "mount", 0.55 * radius, base - 0.027 * length * along, -along, 0.073 * length)
    if stands and elbow[2] > 0.05 * length:
        _add_rod(spec, "column", 0.55 * radius, elbow, -up, elbow[2])
    elif not stands:
        _add_rod(spec, "column", 0.55 * radius, elbow, up, 1.5 * length)
    spec.worldbody.add_geom(
        name=part_name(spec, "elbow"), type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.55 * radius, 0, 0], pos=elbow,
        material="mount", contype=0, conaffinity=0,
    )  # fmt: skip


def _add_rod(
    spec: mujoco.MjSpec, name: str, radius: float, start: np.ndarray, direction: np.ndarray, length: float
) -> None:
    """Add a cylinder that begins at a point and runs in a direction; all in m."""
    quat = np.zeros(4)
    mujoco.mju_quatZ2Vec(quat, direction)
    spec.worldbody.add_geom(
        name=part_name(spec, name), type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[radius, 0.5 * length, 0], quat=quat,
        pos=start + 0.5 * length * direction, material="mount", contype=0, conaffinity=0,
    )  # fmt: skip


def _add_camera(spec: mujoco.MjSpec, name: str, seen: np.ndarray, azimuth: float, elevation: float) -> float:
    """Add a fixed camera at the given angles [deg], as near as still shows all points `seen` [m], shape (T, 3).

    Returns:
        how far before it the farthest of them is [m].
    """
    turn = axes(azimuth, elevation)
    pos = place(seen, 0.0, turn, Frame())
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, turn.T.ravel())
    spec.worldbody.add_camera(name=name, pos=pos, quat=quat, fovy=FOVY)
    return float(((pos - seen) @ turn[2]).max())

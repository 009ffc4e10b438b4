"""A host: the user's own spec that an arm is attached to, whose bodies, options and actuators stay as they are."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco

from contarm_sim.errors import InputError
from contarm_sim.mjcf import names
from contarm_sim.mjcf.objects import OF_OBJECTS
from contarm_sim.model.arm import Arm
from contarm_sim.model.host import Host
from contarm_sim.model.host_file import Key, opened, quiet
from contarm_sim.model.objects import said_of_object

_NAMED = (
    "bodies", "joints", "geoms", "sites", "cameras", "lights", "meshes", "materials", "textures", "tendons",
    "actuators", "sensors", "equalities", "excludes",
)  # fmt: skip
"""Lists of a spec whose parts have names of their own."""

CLASS = "contarm"
"""The defaults class that those of the arm are in, in a host."""

_SHOWN = 6
"""Most names that a message lists."""


def attach(part: mujoco.MjSpec, arm: Arm, host: Host) -> mujoco.MjSpec:
    """Return the host's spec with an arm attached under its plain names, without keyframes.

    Args:
        part: the arm, as of `build.spec`; it is moved.

    Raises:
        InputError: parts of the host have names of the arm's.
    """
    spec = opened(host.file)
    _refuse_collisions(spec, part, arm, host)
    part.default.name = CLASS
    for key in list(spec.keys):
        spec.delete(key)
    parent = spec.body(host.mount)
    with quiet():  # of an empty prefix the engine warns
        if host.site is not None:
            spec.attach(part, site=spec.site(host.site), prefix="")
        else:
            spec.attach(part, frame=parent.add_frame(pos=host.position, quat=host.orientation), prefix="")
    spec = spec.copy()  # which forgets the warning: it would be given again whenever the spec is compiled
    folder = Path(host.file).parent
    spec.meshdir, spec.texturedir = str(folder / spec.meshdir), str(folder / spec.texturedir)
    return spec


def add_host_sensors(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Add sensors of where the base is in the world, and of the positions of all joints that are not the arm's."""
    kind, of = mujoco.mjtSensor, mujoco.mjtObj
    for name, what in (
        (names.sensor(names.BASE, names.POSITION), kind.mjSENS_FRAMEPOS),
        (names.sensor(names.BASE, names.ORIENTATION), kind.mjSENS_FRAMEQUAT),
    ):
        spec.add_sensor(name=name, type=what, objtype=of.mjOBJ_XBODY, objname=names.BASE)
    for joint in spec.joints:
        felt, free = [kind.mjSENS_JOINTPOS], joint.type == mujoco.mjtJoint.mjJNT_FREE
        if free:
            felt = [kind.mjSENS_FRAMEPOS, kind.mjSENS_FRAMEQUAT]
        elif joint.type == mujoco.mjtJoint.mjJNT_BALL:
            felt = [kind.mjSENS_BALLQUAT]
        whose = (of.mjOBJ_XBODY, joint.parent.name) if free else (of.mjOBJ_JOINT, joint.name)
        for name, what in zip(names.host_sensors(arm, joint.name, free), felt, strict=False):
            spec.add_sensor(name=name, type=what, objtype=whose[0], objname=whose[1])


def exclude_mount(spec: mujoco.MjSpec, arm: Arm, host: Host) -> None:
    """Leave out contact of the first links with the body that holds the base.

    Capsules have round ends: in a tube of radius R, bent by 1/R at most, those that begin less than pi R/2 from the
    base reach through its plane, though the tube does not.
    """
    height = 0.0
    for station in names.stations(arm):
        radius, half, _ = spec.geom(f"{station}_collision").size
        if height < 0.5 * math.pi * radius:
            spec.add_exclude(name=f"{station}_mount", bodyname1=station, bodyname2=host.mount)
        height += 2 * half


def add_keys(spec: mujoco.MjSpec, host: Host, qpos: list[float], free: list[float], ctrl: list[float],
             act: list[float]) -> None:  # fmt: skip
    """Add the host's keyframes with the arm in them.

    Args:
        qpos: of the arm's joints.
        free: of the free objects of its world, which come last.
        ctrl, act: of its actuators.
    """
    place, before = host.read.ends[host.mount]
    for key in host.read.keys:
        rates = [*key.qvel[:before], *[0.0] * len(qpos), *key.qvel[before:], *[0.0] * (len(free) // 7 * 6)]
        spec.add_key(
            name=_name(spec, key), qpos=[*key.qpos[:place], *qpos, *key.qpos[place:], *free], qvel=rates,
            act=[*key.act, *act], ctrl=[*key.ctrl, *ctrl], mpos=key.mpos, mquat=key.mquat,
        )  # fmt: skip


def _name(spec: mujoco.MjSpec, key: Key) -> str:
    return key.name or f"key_{len(spec.keys)}"


def _refuse_collisions(spec: mujoco.MjSpec, part: mujoco.MjSpec, arm: Arm, host: Host) -> None:
    found = []
    for kind in _NAMED:
        taken = {each.name for each in getattr(spec, kind)}
        for one in arm.world.objects if kind in OF_OBJECTS else ():
            if one.name in taken:
                allowed = f"another: {Path(host.file).name} has a {_single(kind)} of that name"
                raise InputError("name", repr(one.name), allowed, said_of_object(one.name))
        mine = {each.name for each in getattr(part, kind)}
        found += [f"{_single(kind)} {name}" for name in sorted((taken & mine) - {"", "world"})]
    if found:
        more = f" and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
        raise _collision(host, ", ".join(found[:_SHOWN]) + more)


@contextmanager
def adding(host: Host) -> Iterator[None]:
    """Refuse a host with names of what is added to it: sensors of contact, poses and joints, and what does not touch.

    Raises:
        InputError: the engine finds a name twice.
    """
    try:
        yield
    except ValueError as error:
        found = re.search(r"repeated name '(.*)' in (\w+)", str(error))
        if isinstance(error, InputError) or found is None:
            raise
        raise _collision(host, f"{found[2]} {found[1]}") from None


def _collision(host: Host, found: str) -> InputError:
    given = f"{Path(host.file).name!r} with names of the arm's ({found})"
    return InputError("world", given, "other names for these parts of the world")


def _single(kind: str) -> str:
    return {"bodies": "body", "meshes": "mesh", "equalities": "equality"}.get(kind, kind.removesuffix("s"))

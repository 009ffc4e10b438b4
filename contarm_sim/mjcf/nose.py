"""The round tip of an arm that can touch something, as it is drawn: a soft cap, and nothing that sticks out of it."""

from __future__ import annotations

import math

import mujoco

from contarm_sim.mjcf import names
from contarm_sim.mjcf.backbone import Link, links
from contarm_sim.mjcf.surfaces import cap
from contarm_sim.model.arm import Arm

NOSE = "nose"

SILICONE = (0.90, 0.88, 0.84)
"""Colour of the cap."""

_SUNK = 0.1
"""How far inside the cap spine and muscles end [radii]."""

_WITHIN = 0.97
"""Radius of disks inside the cap over its own at their height: they belong to links that turn against it."""

_TINY = 1e-6
"""Half the length of what is all inside the cap [m]."""


def nose_radius(arm: Arm) -> float:
    """Return the radius of the tip's ball [m]; 0 for arms that are drawn with their plate."""
    radius = links(arm)[-1].contact_radius
    return radius if arm.world.touchable and radius < 0.5 * arm.length else 0.0


def drawn_length(arm: Arm) -> float:
    """Return where along the arm spine and muscles end in pictures [m]."""
    radius = nose_radius(arm)
    return arm.length - (1 - _SUNK) * radius if radius else math.inf


def add_nose(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Draw the cap; the tip's plate becomes its lid, and what lies beyond ends in it."""
    radius = nose_radius(arm)
    if not radius:
        return
    for body, link in zip(names.stations(arm), links(arm), strict=True):
        end = drawn_length(arm) - link.height
        _shorten(spec.geom(f"{body}_spine"), end)
        for muscle in names.muscles(arm):
            strand = spec.geom(names.guide(body, muscle))
            if strand is not None:
                _shorten(strand, end)
        for part in ("disk", "guide"):
            disk = spec.geom(f"{body}_{part}")
            if disk is not None:
                if link.above is None:
                    disk.pos[2], disk.size[0] = -radius, radius
                disk.size[0] = min(disk.size[0], disk_in_nose(link, radius, disk.pos[2], disk.size[1]))
    taken = any(find(NOSE) is not None for find in (spec.body, spec.geom, spec.mesh, spec.material))
    name = f"scene/{NOSE}" if taken else NOSE
    spec.add_material(name=name, rgba=[*SILICONE, 1.0], specular=0.2, shininess=0.3)
    spec.add_mesh(name=name, uservert=cap(radius)[0].ravel())  # the engine takes their hull
    spec.body(names.TIP).add_geom(
        name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, pos=[0.0, 0.0, -radius], material=name, group=2,
        contype=0, conaffinity=0,
    )  # fmt: skip


def disk_in_nose(link: Link, radius: float, height: float, half: float) -> float:
    """Return the largest radius of a disk that stays inside the arm's outside [m].

    Args:
        radius: of the ball [m].
        height, half: of the disk's middle above its station, and half its thickness [m].
    """
    above = link.height + height + half - (link.arm.length - radius)
    share = 1.0 if link.above is None else _WITHIN
    return math.inf if above <= 0 else share * math.sqrt(max(radius**2 - above**2, (0.02 * radius) ** 2))


def _shorten(geom: mujoco.MjsGeom, end: float) -> None:
    """Let a capsule along z end at a height [m] at most."""
    low, high = geom.pos[2] - geom.size[1], geom.pos[2] + geom.size[1]
    if high > end:
        low = min(low, end - 2 * _TINY)
        geom.pos[2], geom.size[1] = 0.5 * (low + end), 0.5 * (end - low)

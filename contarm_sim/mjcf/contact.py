"""How the arm touches: the shape of its links, what contact is like, and the sensors that feel it.

The links are capsules about the backbone, which together are a smooth tube; its end at the tip is round, at the base
they are cylinders.
Where there is nothing to touch, contact is switched off and costs nothing.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from contarm_sim.mjcf import names
from contarm_sim.mjcf.stepping import damp
from contarm_sim.model.arm import Arm

if TYPE_CHECKING:
    from contarm_sim.mjcf.backbone import Link

COLLISION = "collision"

LINKS, ITSELF = 1, 2
"""Bits of contype and conaffinity: what touches links, and links that touch one another."""

SOLREF = (0.01, 1.0)
"""Time constant [s] and damping ratio: no bounce, as of silicone, and as fast as the default step can be, which is two
steps. Slower contact lets what hits at speed sink deeper."""

FREE_SOLREF = (0.01, 2.0)
"""The same of free objects, which have no damping of their own: at a ratio of 1 one in five that merely lie in a groove
gain energy and jump; at 2 none does."""

IMPEDANCE = 0.999
"""Share of a rigid contact's force that a contact has, the same at all depths: a link gives way by 0.001 mm/N. The
remainder makes both contact soft and friction creep; nearer to 1, the engine's line search fails now and then."""

SOLIMP = (IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0)

IMPRATIO = 300.0
"""How much harder friction is than the normal direction: what sticks creeps in proportion to 1/IMPRATIO. At 1000 the
engine's line search fails now and then; its step against slip (`noslip`) ends creep too, but costs up to two steps
where an arm is wrapped around something."""

TOLERANCE = 1e-6
"""Of Newton's iterations: contact forces are within 1e-3 of converged ones, and an arm that rests takes none."""

CORE = 0.1
"""Radius of links that the round tip stands for, over that of contact."""

CONDIM = 3
"""Contacts press and rub; they resist no twist about their normal."""

_DATA = mujoco.mjtConDataField
_NET = 3
_NEAREST = 1
_FELT = {
    names.TOUCH: (_NET, (_DATA.mjCONDATA_FOUND, _DATA.mjCONDATA_FORCE, _DATA.mjCONDATA_POS)),
    names.DEPTH: (_NEAREST, (_DATA.mjCONDATA_DIST, _DATA.mjCONDATA_POS, _DATA.mjCONDATA_NORMAL)),
}
"""Sensors of each link and object: how their contacts are reduced to one, and what is read of it."""


def add_collision_default(spec: mujoco.MjSpec) -> None:
    """Add the defaults class of the geoms that touch."""
    collision = spec.add_default(COLLISION, spec.default)
    collision.geom.contype, collision.geom.conaffinity = LINKS, 0  # meets the world, never its own links
    collision.geom.group = 3
    collision.geom.rgba = [0.5, 0.5, 0.5, 0.3]


def add_collision(spec: mujoco.MjSpec, body: mujoco.MjsBody, link: Link) -> None:
    """Give a link the geom that touches: a capsule about the backbone, near the base a cylinder, the tip a ball.

    The tip is round, a ball within the arm that ends with its plate: a rim that scrapes over something chatters. It
    stands for the links that are nearer to the tip than the radius; a core that touches nothing remains of these.
    """
    low, high = -link.half(link.below), link.half(link.above)
    radius, to_tip = link.contact_radius, link.arm.length - link.height - high
    kind = mujoco.mjtGeom
    shape, place, size = kind.mjGEOM_CAPSULE, 0.5 * (low + high), [radius, 0.5 * (high - low), 0]
    if link.height + low < radius:
        shape = kind.mjGEOM_CYLINDER
    if to_tip < radius and radius < 0.5 * link.arm.length:
        shape, place, size = kind.mjGEOM_SPHERE, 0.0, [CORE * radius, 0, 0]
        if link.above is None:
            place, size = -radius, [radius, 0, 0]
    body.add_geom(spec.find_default(COLLISION), name=f"{body.name}_collision", type=shape, pos=[0, 0, place], size=size)


def make_touchable(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Switch contact on in the spec of an arm that is in it under its plain names, objects too."""
    option = spec.option
    option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = IMPRATIO
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND  # they take 1 to 3 us a step, and save nothing here
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # chains fill their matrices: sparse ones gain nothing
    option.solver, option.tolerance = mujoco.mjtSolver.mjSOL_NEWTON, TOLERANCE
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP  # damping is armature instead, see `stepping`
    damp(spec, arm)
    add_feelers(spec, arm)


def add_feelers(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Give the arm in a spec its contact, and sensors of it; options stay as they are."""
    for body in names.stations(arm):
        geom = spec.geom(f"{body}_collision")
        soften(geom)
        if arm.world.self_contact:
            geom.contype, geom.conaffinity = LINKS | ITSELF, ITSELF
    if arm.world.self_contact:
        _exclude_neighbours(spec, arm)
    _add_sensors(spec, arm)
    _add_pose_sensors(spec, arm)


def leave_out_what_is_drawn(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Delete the arm's geoms that touch nothing: the engine looks for their places before it looks for contact."""
    own = {*names.stations(arm), names.PAYLOAD}
    for geom in spec.geoms:
        if not geom.contype and not geom.conaffinity and geom.parent.name in own:
            spec.delete(geom)


def soften(geom: mujoco.MjsGeom, free: bool = False) -> None:
    """Give a geom the contact of the arm, or of a free object."""
    geom.condim = CONDIM
    geom.solref[:2] = FREE_SOLREF if free else SOLREF
    geom.solimp[:5] = SOLIMP


def _exclude_neighbours(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Leave out pairs of links that are too near along the arm to touch.

    A tube of radius R that is bent as tight as it can be, by 1/R, has points that are s apart along it at a distance of
    2 R sin(s/(2 R)), and no bend of at most 1/R brings them nearer (theorem of Schur): below s = pi R they are nearer
    than 2 R though they do not touch, their capsules overlap in the tube's own inside.
    """
    stations = names.stations(arm)
    sizes = [spec.geom(f"{name}_collision").size for name in stations]
    ends = np.cumsum([0.0, *(2 * size[1] for size in sizes)])
    for place, name in enumerate(stations):
        for other in range(place + 1, len(stations)):
            if ends[other] - ends[place + 1] < 0.5 * math.pi * (sizes[place][0] + sizes[other][0]):
                spec.add_exclude(name=f"{name}_{stations[other]}", bodyname1=name, bodyname2=stations[other])


def _add_sensors(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Add sensors of what each link feels of each object, and of the arm itself."""
    body, tree = mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_XBODY
    partners, host = names.partners(arm), arm.world.host
    lumped = host is not None and host.lumped
    for felt, (reduce, fields) in _FELT.items():
        bits = sum(1 << int(field) for field in fields)
        for partner in partners:
            for station in names.stations(arm):
                spec.add_sensor(
                    name=names.touch_sensor(station, partner, felt), type=mujoco.mjtSensor.mjSENS_CONTACT,
                    objtype=body, objname=station, intprm=[bits, reduce, 1],
                    **({} if lumped else {"reftype": tree if partner == names.BASE else body, "refname": partner}),
                )  # fmt: skip


def _add_pose_sensors(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Add sensors of where free objects are in the base frame."""
    kind, of = mujoco.mjtSensor, mujoco.mjtObj
    for name in arm.world.movable:
        for quantity, what in ((names.POSITION, kind.mjSENS_FRAMEPOS), (names.ORIENTATION, kind.mjSENS_FRAMEQUAT)):
            spec.add_sensor(
                name=names.sensor(name, quantity), type=what, objtype=of.mjOBJ_XBODY, objname=name,
                reftype=of.mjOBJ_SITE, refname=names.BASE,
            )  # fmt: skip

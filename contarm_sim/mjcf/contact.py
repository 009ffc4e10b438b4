"""How the arm touches: the shape of its links, what contact is like, and the sensors that feel it.

The links are capsules about the backbone, which together are a smooth tube; the tip's plate is a cylinder. Where there
is nothing to touch, contact is switched off and costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco

from contarm_sim.mjcf import names
from contarm_sim.model.arm import Arm

if TYPE_CHECKING:
    from contarm_sim.mjcf.backbone import Link

COLLISION = "collision"

LINKS, ITSELF = 1, 2
"""Bits of contype and conaffinity: what touches links, and links that touch one another."""

SOLREF = (0.01, 1.0)
"""Time constant [s] and damping ratio of contact: two default steps, the fastest that is damped critically there."""

IMPEDANCE = 0.999
"""Share of what a rigid contact would do, the same at any depth. A link under 5 N gives way by some hundredths of a
millimetre; friction creeps in proportion to what is missing to 1."""

SOLIMP = (IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0)

IMPRATIO = 100.0
"""How much harder friction is than the normal direction: what sticks creeps by 1 / IMPRATIO of what it would."""

CONDIM = 3
"""Contacts press and rub; they resist no twist about their normal."""

_DATA = mujoco.mjtConDataField
_NET = 3
_NEAREST = 1
_FELT = {
    names.TOUCH: (_NET, (_DATA.mjCONDATA_FOUND, _DATA.mjCONDATA_FORCE, _DATA.mjCONDATA_POS)),
    names.DEPTH: (_NEAREST, (_DATA.mjCONDATA_DIST, _DATA.mjCONDATA_NORMAL)),
}
"""Sensors of each link and object: how their contacts are reduced to one, and what is read of it."""


def add_collision_default(spec: mujoco.MjSpec) -> None:
    """Add the defaults class of the geoms that touch."""
    collision = spec.add_default(COLLISION, spec.default)
    collision.geom.contype, collision.geom.conaffinity = LINKS, 0  # meets the world, never its own links
    collision.geom.group = 3
    collision.geom.rgba = [0.5, 0.5, 0.5, 0.3]


def add_collision(spec: mujoco.MjSpec, body: mujoco.MjsBody, link: Link) -> None:
    """Give a link the geom that touches: a capsule about the backbone, or a cylinder at the arm's ends."""
    low, high = -link.half(link.below), link.half(link.above)
    end = link.below is None or link.above is None
    kind = mujoco.mjtGeom
    body.add_geom(
        spec.find_default(COLLISION), name=f"{body.name}_collision",
        type=kind.mjGEOM_CYLINDER if end else kind.mjGEOM_CAPSULE,
        pos=[0, 0, 0.5 * (low + high)], size=[link.contact_radius, 0.5 * (high - low), 0],
    )  # fmt: skip


def make_touchable(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Switch contact on in the spec of an arm that is in it under its plain names, objects too."""
    option = spec.option
    option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = IMPRATIO
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    _damp_by_armature(spec)
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


def set_step(model: mujoco.MjModel, step: float) -> None:
    """Set the time step [s] of a compiled model, and the armature that damping is where contact is on.

    `implicitfast` steps by (M + step D) dv = step (f + contact), with damping D, but its contact solver sees M alone:
    links are so light and so damped (step D is up to 500 M) that their contact buzzes. With step D as armature, plain
    Euler steps by the very same equation, and contact sees all of it.
    """
    model.opt.timestep = step
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_EULERDAMP:
        step = step if model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER else 0.0
        model.dof_armature[:] = step * model.dof_damping
        model.tendon_armature[:] = step * model.tendon_damping


def _damp_by_armature(spec: mujoco.MjSpec) -> None:
    """Do in a spec what `set_step` does in a model."""
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    for each in (*spec.joints, *spec.tendons):
        each.armature = spec.option.timestep * each.damping[0]


def soften(geom: mujoco.MjsGeom) -> None:
    """Give a geom the contact of the arm."""
    geom.condim = CONDIM
    geom.solref[:2] = SOLREF
    geom.solimp[:5] = SOLIMP


def _exclude_neighbours(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Leave out pairs of links whose tubes overlap however little the arm is bent."""
    stations = names.stations(arm)
    for place, name in enumerate(stations):
        for other in stations[place + 1 : place + 5]:
            spec.add_exclude(name=f"{name}_{other}", bodyname1=name, bodyname2=other)


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
    for name in names.free_objects(arm):
        for quantity, what in ((names.POSITION, kind.mjSENS_FRAMEPOS), (names.ORIENTATION, kind.mjSENS_FRAMEQUAT)):
            spec.add_sensor(
                name=names.sensor(name, quantity), type=what, objtype=of.mjOBJ_XBODY, objname=name,
                reftype=of.mjOBJ_SITE, refname=names.BASE,
            )  # fmt: skip

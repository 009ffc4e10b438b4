"""The rigid-link backbone as MjSpec elements.

Body frames sit at the stations s = i h (base plate, disks, tip plate), so `xpos` *is* the
centreline. Joints lie half a pitch below: a half link is fixed to the base, full links carry a disk in their
middle, a half link ends in the tip. Two hinges make a joint, three where the backbone twists; their order runs xy, yx,
yx, xy (xyz, zyx, zyx, xyz) along the chain, which cancels what a fixed order accumulates (second instead of first order
in the pitch).
"""

from __future__ import annotations

import math

import mujoco

from contarm_sim.model.arm import Arm

AXES = {"x": [1.0, 0.0, 0.0], "y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 1.0]}
VISUAL, COLLISION = "visual", "collision"

HARD = [0.9999, 0.9999]
"""Impedance of dry friction, the most that the engine takes."""

_STEEL = 7850.0  # kg/m^3

SPINE_RADIUS = 0.22
"""Radius of the drawn spine over the attachment radius."""


def payload_radius(arm: Arm) -> float:
    """Return the radius of the payload's ball of steel [m]."""
    return (3 * arm.payload / (4 * math.pi * _STEEL)) ** (1 / 3)


def station_names(arm: Arm) -> list[str]:
    """Return the names of the bodies at stations 0 (base), 1 .. N - 1 (links), N (tip)."""
    return ["base", *(f"link_{i:02d}" for i in range(1, arm.links)), "tip"]


def joint_axes(arm: Arm, index: int) -> str:
    """Return the hinge order of joint `index` (from 0), parent side first."""
    if arm.torsional_stiffness is None:
        return ("xy", "yx", "yx", "xy")[index % 4]
    return ("xyz", "zyx", "zyx", "xyz")[index % 4]


def add_defaults(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Add the defaults classes: bending and torsion joints, visual and collision geoms."""
    k = arm.bending_stiffness / arm.link_pitch
    bending = spec.add_default("bending", spec.default)
    bending.joint.type = mujoco.mjtJoint.mjJNT_HINGE
    bending.joint.stiffness = [k, 0, 0]
    bending.joint.damping = [arm.damping_time * k, 0, 0]
    _rub(bending, arm)
    if arm.torsional_stiffness is not None:
        k_t = twist_stiffness(arm, 3 * arm.muscle.min_tension)
        torsion = spec.add_default("torsion", spec.default)
        torsion.joint.type = mujoco.mjtJoint.mjJNT_HINGE
        torsion.joint.stiffness = [k_t, 0, 0]
        torsion.joint.damping = [arm.damping_time * arm.torsional_stiffness / arm.link_pitch, 0, 0]
        _rub(torsion, arm)
    visual = spec.add_default(VISUAL, spec.default)
    visual.geom.contype = visual.geom.conaffinity = 0
    visual.geom.group = 2
    collision = spec.add_default(COLLISION, spec.default)
    collision.geom.contype, collision.geom.conaffinity = 1, 0  # meets the world, never its own links
    collision.geom.group = 3
    collision.geom.rgba = [0.5, 0.5, 0.5, 0.3]


def twist_stiffness(arm: Arm, tension: float) -> float:
    """Return the stiffness [N m/rad] of a joint against twist under a sum of muscle tensions [N].

    A twisted muscle that runs parallel to the backbone is a helix, and longer: it adds r^2 T to GJ. Fixed tendons do
    not feel that, so it goes to the joint; straight spans feel it by themselves.
    """
    assert arm.torsional_stiffness is not None
    pulled = arm.muscle_radius**2 * tension if arm.muscle.path == "parallel" else 0.0
    return (arm.torsional_stiffness + pulled) / arm.link_pitch


def _rub(default: mujoco.MjsDefault, arm: Arm) -> None:
    """Add dry friction, as hard as the engine makes it: it still creeps, the faster the lighter the links."""
    if arm.joint_friction is not None:
        default.joint.frictionloss = arm.joint_friction
        default.joint.solimp_friction[:2] = HARD


def add_backbone(spec: mujoco.MjSpec, arm: Arm) -> list[mujoco.MjsBody]:
    """Add base, links and tip to the world; return the bodies at stations 0 .. N."""
    h = arm.link_pitch
    base = spec.worldbody.add_body(name="base")
    _set_inertia(base, arm, 0.5, 0.25 * h)
    _add_visuals(spec, base, arm, 0.0, 0.5 * h)
    bodies = [base]
    for index, name in enumerate(station_names(arm)[1:]):
        body = bodies[-1].add_body(name=name, pos=[0.0, 0.0, h])
        for axis in joint_axes(arm, index):
            body.add_joint(
                spec.find_default("torsion" if axis == "z" else "bending"),
                name=f"joint_{index + 1:02d}_{axis}",
                axis=AXES[axis],
                pos=[0.0, 0.0, -0.5 * h],
            )
        last = name == "tip"
        _set_inertia(body, arm, 0.5 if last else 1.0, -0.25 * h if last else 0.0)
        _add_visuals(spec, body, arm, -0.5 * h, 0.0 if last else 0.5 * h)
        bodies.append(body)
    base.add_site(name="base", group=4)
    bodies[-1].add_site(name="tip", group=4)
    _add_payload(spec, bodies[-1], arm)
    return bodies


def _set_inertia(body: mujoco.MjsBody, arm: Arm, share: float, middle: float) -> None:
    """Give a link its share of the arm's mass as a solid cylinder centred at z = `middle` [m]."""
    mass, height, radius = share * arm.mass / arm.links, share * arm.link_pitch, arm.section_radius or arm.disk_radius
    lateral = mass * (radius**2 / 4 + height**2 / 12)
    body.explicitinertial = True
    body.mass = mass
    body.ipos = [0.0, 0.0, middle]
    body.inertia = [lateral, lateral, mass * radius**2 / 2]


def _add_payload(spec: mujoco.MjSpec, tip: mujoco.MjsBody, arm: Arm) -> None:
    """Add a body for the payload, a point mass at the tip, fixed to it, and draw it as a steel ball.

    It is there without payload too: forces that the engine applies to its centre of mass act at the tip.
    """
    payload = tip.add_body(name="payload")
    payload.explicitinertial = True
    payload.mass = arm.payload
    payload.ipos = [0.0, 0.0, 0.0]
    payload.inertia = [0.0, 0.0, 0.0]
    if arm.payload:
        payload.add_geom(
            spec.find_default(VISUAL), name="payload", type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[payload_radius(arm), 0, 0], material="steel",
        )  # fmt: skip


def _add_visuals(spec: mujoco.MjSpec, body: mujoco.MjsBody, arm: Arm, low: float, high: float) -> None:
    """Draw a link from z = low to high about its disk, and give it a collision cylinder."""
    h, radius = arm.link_pitch, arm.disk_radius
    visual = spec.find_default(VISUAL)
    spine = SPINE_RADIUS * arm.muscle_radius
    ends = body.name in ("base", "tip")
    thickness = min(0.0035 if ends else 0.0022, 0.2 * h)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    body.add_geom(
        visual, name=f"{body.name}_spine", type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        pos=[0, 0, middle], size=[spine, half, 0], material="spine",
    )  # fmt: skip
    spans = arm.muscle.path == "spans"  # their disks guide the muscles
    body.add_geom(
        visual, name=f"{body.name}_disk", type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[0, 0, arm.guide_height if spans and not ends else 0.0],
        size=[radius, 0.5 * thickness, 0], material="plate" if ends else "disk",
    )  # fmt: skip
    if spans and body.name == "base":
        body.add_geom(
            visual, name="base_guide", type=mujoco.mjtGeom.mjGEOM_CYLINDER, pos=[0, 0, arm.guide_height],
            size=[radius, 0.5 * min(0.0022, 0.2 * h), 0], material="disk",
        )  # fmt: skip
    body.add_geom(
        spec.find_default(COLLISION), name=f"{body.name}_collision", type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[0, 0, middle], size=[radius, half, 0],
    )  # fmt: skip

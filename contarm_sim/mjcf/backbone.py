"""The rigid-link backbone as MjSpec elements.

Body frames sit at the stations s = i h (base plate, disks, tip plate), so `xpos` *is* the
centreline. Joints lie half a pitch below: a half link is fixed to the base, full links carry a disk in their
middle, a half link ends in the tip. Where a section ends and another begins, the half links of both are one
body. Two hinges make a joint, three where the backbone twists; their order runs xy, yx,
yx, xy (xyz, zyx, zyx, xyz) along the chain, which cancels what a fixed order accumulates (second instead of first order
in the pitch).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco

from contarm_sim.mjcf import names
from contarm_sim.mjcf.contact import add_collision, add_collision_default
from contarm_sim.model.arm import Arm
from contarm_sim.model.section import Section

AXES = {"x": [1.0, 0.0, 0.0], "y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 1.0]}
VISUAL = "visual"

HARD = [0.9999, 0.9999]
"""Impedance of dry friction, the most that the engine takes."""

_STEEL = 7850.0  # kg/m^3

SPINE_RADIUS = 0.22
"""Radius of the drawn spine over the attachment radius."""


def payload_radius(arm: Arm) -> float:
    """Return the radius of the payload's ball of steel [m]."""
    return (3 * arm.payload / (4 * math.pi * _STEEL)) ** (1 / 3)


def add_defaults(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Add the defaults classes: bending and torsion joints of each section, visual and collision geoms."""
    for number, section in enumerate(arm.sections):
        bending = spec.add_default(_joint_class(arm, number, "x"), spec.default)
        bending.joint.type = mujoco.mjtJoint.mjJNT_HINGE
        bending.joint.stiffness = [section.joint_stiffness, 0, 0]
        bending.joint.damping = [section.damping_time * section.joint_stiffness, 0, 0]
        _rub(bending, section)
        if section.torsional_stiffness is not None:
            torsion = spec.add_default(_joint_class(arm, number, "z"), spec.default)
            torsion.joint.type = mujoco.mjtJoint.mjJNT_HINGE
            torsion.joint.stiffness = [twist_stiffness(arm, number), 0, 0]
            torsion.joint.damping = [section.damping_time * section.torsional_stiffness / section.link_pitch, 0, 0]
            _rub(torsion, section)
    visual = spec.add_default(VISUAL, spec.default)
    visual.geom.contype = visual.geom.conaffinity = 0
    visual.geom.group = 2
    add_collision_default(spec)


def _joint_class(arm: Arm, section: int, axis: str) -> str:
    return names.of_section(arm, section) + ("torsion" if axis == "z" else "bending")


def twist_stiffness(arm: Arm, section: int) -> float:
    """Return the stiffness [N m/rad] of a section's joints against twist, its muscles at their least tension.

    A twisted muscle that runs parallel to the backbone is a helix, and longer: it adds r^2 T to GJ. Fixed tendons do
    not feel that, so it goes to the joint; straight spans feel it by themselves.
    """
    one = arm.sections[section]
    assert one.torsional_stiffness is not None
    pulled = 0.0
    for group in arm.groups:
        if group.crosses(section) and group.routing.path == "parallel":
            pulled += group.routing.radius**2 * (group.routing.count * group.law.min_tension)
    return (one.torsional_stiffness + pulled) / one.link_pitch


def _rub(default: mujoco.MjsDefault, section: Section) -> None:
    """Add dry friction, as hard as the engine makes it: it still creeps, the faster the lighter the links."""
    if section.joint_friction is not None:
        default.joint.frictionloss = section.joint_friction
        default.joint.solimp_friction[:2] = HARD


def add_backbone(spec: mujoco.MjSpec, arm: Arm) -> list[mujoco.MjsBody]:
    """Add base, links and tip to the world; return the bodies at the stations."""
    bodies: list[mujoco.MjsBody] = []
    joints = names.joints(arm)
    for station, (name, link) in enumerate(zip(names.stations(arm), links(arm), strict=True)):
        h = arm.sections[link.sections[0]].link_pitch
        place = {"pos": [0.0, 0.0, h]} if bodies else {}
        body = (bodies[-1] if bodies else spec.worldbody).add_body(name=name, **place)
        for joint in joints:
            if joint.station == station:
                body.add_joint(
                    spec.find_default(_joint_class(arm, joint.section, joint.axis)), name=joint.name,
                    axis=AXES[joint.axis], pos=[0.0, 0.0, -0.5 * h],
                )  # fmt: skip
        _set_inertia(body, link)
        _add_visuals(spec, body, link)
        bodies.append(body)
    bodies[0].add_site(name=names.BASE, group=4)
    bodies[-1].add_site(name=names.TIP, group=4)
    _add_payload(spec, bodies[-1], arm)
    return bodies


@dataclass(frozen=True)
class Link:
    """A rigid link about its station: the numbers of the sections of its half below and of its half above, or None.

    Its station is at `height` along the straight arm [m].
    """

    arm: Arm
    below: int | None
    above: int | None
    height: float

    @property
    def inner(self) -> bool:
        """Whether it is a full link within a section: no plate."""
        return self.below == self.above

    @property
    def sections(self) -> list[int]:
        """The sections that it belongs to."""
        return [number for number in dict.fromkeys((self.below, self.above)) if number is not None]

    def half(self, section: int | None) -> float:
        """Return half a pitch of a section [m], 0 for None."""
        return 0.0 if section is None else 0.5 * self.arm.sections[section].link_pitch

    @property
    def disk_radius(self) -> float:
        """Radius of its disk or plate [m]."""
        return max(self.arm.disk_radii[number] for number in self.sections)

    @property
    def contact_radius(self) -> float:
        """Radius of what touches [m]."""
        return max(self.arm.contact_radii[number] for number in self.sections)


def links(arm: Arm) -> list[Link]:
    """Return the links at the stations, from base to tip."""
    starts, last = names.section_stations(arm), len(arm.sections)
    heights = [0.0]
    for section in arm.sections:
        heights += [heights[-1] + section.link_pitch * (place + 1) for place in range(section.links)]
    found = []
    for station in range(len(names.stations(arm))):
        below = sum(station > start for start in starts) - 1  # number of the section that ends here or goes on
        above = sum(station >= start for start in starts) - 1
        found.append(Link(arm, below if below >= 0 else None, above if above < last else None, heights[station]))
    return found


def inertia(link: Link) -> tuple[float, float, float, float]:
    """Return the mass of a link [kg], its middle above the station [m], and its inertia across and along [kg m^2].

    It is its share of its sections' masses, as solid cylinders.
    """
    parts = []
    for number in link.sections:
        section = link.arm.sections[number]
        share = 1.0 if link.inner else 0.5
        middle = 0.0 if link.inner else (0.25 if number == link.above else -0.25) * section.link_pitch
        mass, height = share * section.mass / section.links, share * section.link_pitch
        radius = section.section_radius or link.arm.disk_radii[number]
        parts.append((mass, middle, mass * (radius**2 / 4 + height**2 / 12), mass * radius**2 / 2))
    if len(parts) == 1:
        return parts[0]
    mass = sum(part[0] for part in parts)
    middle = sum(part[0] * part[1] for part in parts) / mass
    lateral = sum(part[2] + part[0] * (part[1] - middle) ** 2 for part in parts)
    return mass, middle, lateral, sum(part[3] for part in parts)


def _set_inertia(body: mujoco.MjsBody, link: Link) -> None:
    mass, middle, lateral, axial = inertia(link)
    body.explicitinertial = True
    body.mass = mass
    body.ipos = [0.0, 0.0, middle]
    body.inertia = [lateral, lateral, axial]


def _add_payload(spec: mujoco.MjSpec, tip: mujoco.MjsBody, arm: Arm) -> None:
    """Add a body for the payload, a point mass at the tip, fixed to it, and draw it as a steel ball.

    It is there without payload too: forces that the engine applies to its centre of mass act at the tip.
    """
    payload = tip.add_body(name=names.PAYLOAD)
    payload.explicitinertial = True
    payload.mass = arm.payload
    payload.ipos = [0.0, 0.0, 0.0]
    payload.inertia = [0.0, 0.0, 0.0]
    if arm.payload:
        payload.add_geom(
            spec.find_default(VISUAL), name="payload", type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[payload_radius(arm), 0, 0], material="steel",
        )  # fmt: skip


def _add_visuals(spec: mujoco.MjSpec, body: mujoco.MjsBody, link: Link) -> None:
    """Draw a link about its disk or plate, and give it the geom that touches."""
    arm, low, high = link.arm, -link.half(link.below), link.half(link.above)
    number = link.sections[-1]
    h, radius, guide = arm.sections[number].link_pitch, link.disk_radius, arm.sections[number].guide_height
    visual = spec.find_default(VISUAL)
    spine = SPINE_RADIUS * min(arm.routings[section].radius for section in link.sections)
    plate = not link.inner
    thickness = min(0.0035 if plate else 0.0022, 0.2 * h)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    body.add_geom(
        visual, name=f"{body.name}_spine", type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        pos=[0, 0, middle], size=[spine, half, 0], material="spine",
    )  # fmt: skip
    # Disks guide the muscles that run in straight spans, those of sections beyond among them.
    spans = any(group.crosses(number) and group.routing.path == "spans" for group in arm.groups)
    body.add_geom(
        visual, name=f"{body.name}_disk", type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[0, 0, guide if spans and not plate else 0.0],
        size=[radius, 0.5 * thickness, 0], material="plate" if plate else "disk",
    )  # fmt: skip
    if spans and plate and link.above is not None:
        body.add_geom(
            visual, name=f"{body.name}_guide", type=mujoco.mjtGeom.mjGEOM_CYLINDER, pos=[0, 0, guide],
            size=[radius, 0.5 * min(0.0022, 0.2 * h), 0], material="disk",
        )  # fmt: skip
    add_collision(spec, body, link)

"""Where the muscles run: tendons, and what is drawn of them.

`parallel`: a muscle sheathed along the backbone at radius r works T r per unit of bending at every joint, which is a
fixed tendon, linear in the joint angles: -r cos(psi) on hinges about y, r sin(psi) on hinges about x. The engine counts
its length from zero, which is the straight arm's. Drawn as a capsule on each link, for fixed tendons are invisible.

`spans`: spatial tendons, straight from guide to guide, one guide a link; the engine counts their whole length.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import mujoco

from contarm_sim.mjcf import names
from contarm_sim.mjcf.backbone import HARD, VISUAL
from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import muscle_colour
from contarm_sim.model.muscle_group import MuscleGroup

CLASS = "muscle"
"""The default class of tendons, guides and length servos, after what the section's names begin with."""


@dataclass(frozen=True)
class Strands:
    """The muscles of one section in a spec: what they are, their names, and their default class."""

    group: MuscleGroup
    names: list[str]
    default: mujoco.MjsDefault


def counted_from(group: MuscleGroup) -> float:
    """Return the muscle length [m] at which the engine's tendon lengths are zero."""
    return group.length if group.routing.path == "parallel" else 0.0


def coefficient(group: MuscleGroup, muscle: int, joint: names.Joint) -> float:
    """Return what a parallel muscle (from 0) gains in length by the angle of a hinge [m/rad]."""
    x, y = group.routing.points[muscle]
    return {"x": y, "y": -x, "z": 0.0}[joint.axis] if group.crosses(joint.section) else 0.0


def add_tendons(
    spec: mujoco.MjSpec, arm: Arm, group: MuscleGroup, bodies: list[mujoco.MjsBody], damping: float
) -> Strands:
    """Add the muscles of one section as tendons, with damping [N s/m], dry friction and silicone.

    Args:
        bodies: at all stations of the arm.
        damping: along each muscle.
    """
    default = spec.add_default(names.of_section(arm, group.section) + CLASS, spec.default)
    default.tendon.damping = [damping, 0, 0]
    if group.law.dry_friction is not None:
        default.tendon.frictionloss = group.law.dry_friction
        default.tendon.solimp_friction[:2] = HARD
    if group.law.passive_stiffness is not None:  # slack up to the rest length
        zero = counted_from(group)
        default.tendon.stiffness = [group.law.passive_stiffness, 0, 0]
        default.tendon.springlength = [-zero, group.rest_length - zero]
    strands = Strands(group, names.group_muscles(arm, group), default)
    if group.routing.path == "parallel":
        _add_parallel(spec, arm, strands, bodies)
    else:
        _add_spans(spec, arm, strands, bodies)
    return strands


def _add_parallel(spec: mujoco.MjSpec, arm: Arm, strands: Strands, bodies: list[mujoco.MjsBody]) -> None:
    group, starts = strands.group, names.section_stations(arm)
    joints = [joint for joint in names.joints(arm) if group.crosses(joint.section) and joint.axis != "z"]
    for index, name in enumerate(strands.names):
        x, y = group.routing.points[index]
        tendon = spec.add_tendon(strands.default, name=name)
        for joint in joints:
            tendon.wrap_joint(joint.name, coefficient(group, index, joint))
        spec.add_material(name=name, rgba=muscle_colour(index), specular=0.5, shininess=0.5)
        for station in range(starts[group.first], starts[group.section + 1] + 1):
            low, high = _reach(arm, group, station)
            bodies[station].add_geom(
                spec.find_default(VISUAL), name=names.guide(bodies[station].name, name),
                type=mujoco.mjtGeom.mjGEOM_CAPSULE, pos=[x, y, 0.5 * (low + high)],
                size=[0.5 * group.law.diameter, 0.5 * (high - low), 0], material=name,
            )  # fmt: skip


def _reach(arm: Arm, group: MuscleGroup, station: int) -> tuple[float, float]:
    """Return from which to which height [m] of a station's link a muscle lies along it."""
    low = high = 0.0
    for number, (start, end) in enumerate(pairwise(names.section_stations(arm))):
        half = 0.5 * arm.sections[number].link_pitch
        if group.crosses(number):
            low = -half if start < station <= end else low
            high = half if start <= station < end else high
    return low, high


def _add_spans(spec: mujoco.MjSpec, arm: Arm, strands: Strands, bodies: list[mujoco.MjsBody]) -> None:
    group, starts = strands.group, names.section_stations(arm)
    strands.default.tendon.width = 0.5 * group.law.diameter
    strands.default.site.group = 4
    strands.default.site.size = [0.002, 0.002, 0.002]
    first, last = bodies[starts[group.first]], bodies[starts[group.section + 1]]
    for index, name in enumerate(strands.names):
        x, y = group.routing.points[index]
        tendon = spec.add_tendon(strands.default, name=name, rgba=muscle_colour(index))
        guides = [(names.guide(first.name, name) + "_root", first, 0.0)]
        for number in range(group.first, group.section + 1):
            height = arm.sections[number].guide_height
            along = bodies[starts[number] : starts[number + 1]]
            guides += [(names.guide(body.name, name), body, height) for body in along]
        guides.append((names.guide(last.name, name), last, 0.0))
        for guide, body, z in guides:
            body.add_site(strands.default, name=guide, pos=[x, y, z])
            tendon.wrap_site(guide)

"""Where the three muscles run: tendons, and what is drawn of them.

`parallel`: a muscle sheathed along the backbone at radius r works T r per unit of bending at every joint, which is a
fixed tendon, linear in the joint angles: -r cos(psi) on hinges about y, r sin(psi) on hinges about x. The engine counts
its length from zero, which is the straight arm's. Drawn as a capsule on each link, for fixed tendons are invisible.

`spans`: spatial tendons, straight from guide to guide, one guide a link; the engine counts their whole length.
"""

from __future__ import annotations

import math

import mujoco

from contarm_sim.mjcf.backbone import HARD, VISUAL
from contarm_sim.model.arm import Arm

MUSCLES = ("muscle_1", "muscle_2", "muscle_3")
COLOURS = ([0.84, 0.15, 0.16, 1.0], [0.17, 0.50, 0.72, 1.0], [0.95, 0.63, 0.10, 1.0])

CLASS = "muscle"
"""The default class of tendons, guides and length servos."""


def angle(index: int) -> float:
    """Return the angle psi [rad] of muscle `index` (from 0) about +Z from +X."""
    return 2 * math.pi * index / 3


def counted_from(arm: Arm) -> float:
    """Return the muscle length [m] at which the engine's tendon lengths are zero."""
    return arm.length if arm.muscle.path == "parallel" else 0.0


def coefficient(arm: Arm, muscle: int, joint: str) -> float:
    """Return what a parallel muscle (from 0) gains in length by the angle of a hinge, named after its axis [m/rad]."""
    if joint.endswith("x"):
        return arm.muscle_radius * math.sin(angle(muscle))
    return -arm.muscle_radius * math.cos(angle(muscle)) if joint.endswith("y") else 0.0


def add_tendons(spec: mujoco.MjSpec, arm: Arm, bodies: list[mujoco.MjsBody], damping: float) -> mujoco.MjsDefault:
    """Add the muscles as tendons, with damping [N s/m], dry friction and silicone; return their default class.

    Args:
        bodies: at stations 0 .. N.
        damping: along each muscle.
    """
    muscle = spec.add_default(CLASS, spec.default)
    muscle.tendon.damping = [damping, 0, 0]
    if arm.muscle.braid_friction is not None:
        muscle.tendon.frictionloss = arm.muscle.braid_friction
        muscle.tendon.solimp_friction[:2] = HARD
    if arm.muscle.passive_stiffness is not None:  # slack up to the rest length
        zero = counted_from(arm)
        muscle.tendon.stiffness = [arm.muscle.passive_stiffness, 0, 0]
        muscle.tendon.springlength = [-zero, arm.muscle_rest_length - zero]
    if arm.muscle.path == "parallel":
        _add_parallel(spec, arm, bodies, muscle)
    else:
        _add_spans(spec, arm, bodies, muscle)
    return muscle


def _add_parallel(spec: mujoco.MjSpec, arm: Arm, bodies: list[mujoco.MjsBody], muscle: mujoco.MjsDefault) -> None:
    radius, half = arm.muscle_radius, 0.5 * arm.link_pitch
    joints = [joint for body in bodies for joint in body.joints]
    for index, name in enumerate(MUSCLES):
        x, y = radius * math.cos(angle(index)), radius * math.sin(angle(index))
        tendon = spec.add_tendon(muscle, name=name)
        for joint in joints:
            if not joint.name.endswith("z"):
                tendon.wrap_joint(joint.name, coefficient(arm, index, joint.name))
        spec.add_material(name=name, rgba=COLOURS[index], specular=0.5, shininess=0.5)
        for body in bodies:
            low, high = (0.0 if body.name == "base" else -half), (0.0 if body.name == "tip" else half)
            body.add_geom(
                spec.find_default(VISUAL), name=f"{body.name}_{name}", type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                pos=[x, y, 0.5 * (low + high)], size=[0.5 * arm.muscle.diameter, 0.5 * (high - low), 0], material=name,
            )  # fmt: skip


def _add_spans(spec: mujoco.MjSpec, arm: Arm, bodies: list[mujoco.MjsBody], muscle: mujoco.MjsDefault) -> None:
    muscle.tendon.width = 0.5 * arm.muscle.diameter
    muscle.site.group = 4
    muscle.site.size = [0.002, 0.002, 0.002]
    for index, name in enumerate(MUSCLES):
        x, y = arm.muscle_radius * math.cos(angle(index)), arm.muscle_radius * math.sin(angle(index))
        tendon = spec.add_tendon(muscle, name=name, rgba=COLOURS[index])
        guides = [(f"base_{name}_root", bodies[0], 0.0)]
        guides += [(f"{body.name}_{name}", body, arm.guide_height) for body in bodies[:-1]]
        guides += [(f"tip_{name}", bodies[-1], 0.0)]
        for guide, body, z in guides:
            body.add_site(muscle, name=guide, pos=[x, y, z])
            tendon.wrap_site(guide)

"""Arm to MjSpec: the attachable arm, and the arm in its scene."""

from __future__ import annotations

import mujoco

from contarm_sim.arm import Arm
from contarm_sim.mjcf.backbone import add_backbone, add_defaults
from contarm_sim.mjcf.muscles import MUSCLES, Actuation, add_muscles, add_sensors, straight_control
from contarm_sim.mjcf.scene import add_scene, base_quaternion, world_gravity

TIMESTEP = 0.005
"""Default time step [s]: the largest that errs by at most 0.02 % of length along the spiral, hanging with 100 g too."""

_MATERIALS = {
    "spine": ([0.82, 0.83, 0.85, 1.0], 0.6, 0.5),
    "disk": ([0.30, 0.32, 0.36, 1.0], 0.3, 0.4),
    "plate": ([0.18, 0.19, 0.22, 1.0], 0.5, 0.6),
    "steel": ([0.62, 0.64, 0.67, 1.0], 0.9, 0.8),
}


def arm_spec(arm: Arm, actuation: Actuation = "lengths") -> mujoco.MjSpec:
    """Return the arm alone: base body at the world's origin, ready to be attached or compiled.

    Gravity is the arm's own, in the base frame, which is the world frame here.

    Args:
        actuation: `lengths`: three length servos [m]. `pressures`: McKibben muscles behind valves, two actuators
            each, which both take the muscle's gauge pressure [Pa]: controls are p1 p2 p3 p1 p2 p3. `tensions`: three
            plain forces, controls are tensions [N].

    Raises:
        InputError: an unknown actuation.
    """
    spec = mujoco.MjSpec()
    spec.modelname = "contarm"
    spec.compiler.degree = False
    spec.compiler.autolimits = False
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = arm.gravity
    for name, (rgba, specular, shininess) in _MATERIALS.items():
        spec.add_material(name=name, rgba=rgba, specular=specular, shininess=shininess)
    add_defaults(spec, arm)
    bodies = add_backbone(spec, arm)
    add_muscles(spec, arm, bodies, actuation)
    add_sensors(spec)
    dofs = arm.links * (3 if arm.torsional_stiffness is not None else 2)
    straight = [straight_control(arm, actuation)] * len(MUSCLES)
    if actuation != "pressures":
        spec.add_key(name="straight", qpos=[0.0] * dofs, ctrl=straight)
    else:
        spec.add_key(name="straight", qpos=[0.0] * dofs, ctrl=2 * straight, act=2 * straight)
    spec.stat.extent = 1.2 * arm.length
    spec.stat.center = [0.0, 0.0, 0.5 * arm.length]
    return spec


def scene_spec(arm: Arm, actuation: Actuation = "lengths") -> mujoco.MjSpec:
    """Return the arm on its mount above a floor, with light and cameras.

    The base is turned by `arm.base_orientation`; if omitted, so that gravity points down the picture.
    """
    spec = arm_spec(arm, actuation)
    spec.modelname = "contarm_scene"
    spec.option.gravity = world_gravity(arm)
    base = spec.body("base")
    base.pos = add_scene(spec, arm)
    base.quat = base_quaternion(arm)
    return spec

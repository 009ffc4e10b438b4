"""Arm to MjSpec: the part that a host takes in, the arm alone, and the arm in its scene."""

from __future__ import annotations

import mujoco
import numpy as np

from contarm_sim.mjcf.backbone import add_backbone, add_defaults
from contarm_sim.mjcf.contact import add_feelers, make_touchable
from contarm_sim.mjcf.host import add_host_sensors, add_keys, adding, attach, exclude_mount
from contarm_sim.mjcf.muscles import ACTUATORS, Actuation, add_muscles, add_sensors, straight_controls
from contarm_sim.mjcf.nose import add_nose
from contarm_sim.mjcf.object_looks import dress_objects
from contarm_sim.mjcf.objects import add_objects, place_objects
from contarm_sim.mjcf.scene import add_scene, add_to_host, base_quaternion, world_gravity
from contarm_sim.mjcf.stability import longest_step
from contarm_sim.mjcf.stepping import damp
from contarm_sim.model.arm import Arm
from contarm_sim.model.host import Host

TIMESTEP = 0.005
"""Longest time step [s]: errs by at most 0.02 % of length along the default arm's spiral, hanging with 100 g too."""

_MATERIALS = {
    "spine": ([0.82, 0.83, 0.85, 1.0], 0.6, 0.5),
    "disk": ([0.30, 0.32, 0.36, 1.0], 0.3, 0.4),
    "plate": ([0.18, 0.19, 0.22, 1.0], 0.5, 0.6),
    "steel": ([0.62, 0.64, 0.67, 1.0], 0.9, 0.8),
}


def spec(arm: Arm, actuation: Actuation = "lengths") -> mujoco.MjSpec:
    """Return the arm as a part of other models: no options, keyframes or statistics, all the rest comes along.

        host.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        host.attach(contarm_sim.spec(arm), site="mount", prefix="left/")  # or frame=host.worldbody.add_frame(...)
        data.actuator("left/muscle_1").ctrl = -0.01  # shorten by 10 mm; at 0 the arm is held straight

    The base plate's centre goes to the site's or frame's origin, +Z along the straight arm, +X towards muscle 1; the
    base is welded there and moves with it. Every name gets the prefix: bodies `base`, `link_01`, ..., `tip`, sites
    `base` and `tip`, tendons and length servos `muscle_1` to `muscle_3` (by pressure: actuators `muscle_1_linear`
    and `muscle_1_quadratic`), sensors `tip_position`, `muscle_1_length`, ..., materials and defaults. MuJoCo warns
    of an empty prefix. A spec is moved into its host: make one for each arm. In an arm of several sections all names
    but `base`, `tip`, `payload` and `tip_position`, `tip_orientation` begin with their section's: `section_2_link_03`,
    `section_2_joint_03_x`, `section_2_muscle_1`; the plate at the end of section 1 is `section_1_tip`.

    All is in SI units, whatever angles the host is written in. What the host brings:

    * the integrator: `implicitfast` or `implicit`, with time steps to 5 ms, or to what `arm_spec` says for arms that
      need less. Under `Euler`, MuJoCo's default, and `RK4` the damping along muscles driven by lengths makes the arm
      diverge.
    * gravity: `arm.gravity` and `arm.base_orientation` are left out.
    * controls, which do no harm at zero: length servos then hold the arm straight, without pressure or tension it is
      limp.

    The links touch geoms whose `conaffinity` has the lowest bit set; never each other, nor another such arm.

    Args:
        actuation: `lengths`: a length servo for each muscle; controls are length changes from the straight arm [m],
            shortening negative. `pressures`: McKibben muscles behind valves, two actuators each, which both take the
            muscle's gauge pressure [Pa]: controls of n muscles are p1 ... pn p1 ... pn. `tensions`: a plain force for
            each muscle; controls are tensions [N].

    Raises:
        InputError: an unknown actuation, friction in the backbone, which MJCF does not have, or objects: they stay in
            the host.
    """
    arm.refuse_memory("MJCF models, environments and the live view are")
    arm.refuse_objects("parts of other models, which bring objects of their own, are made")
    part = mujoco.MjSpec()
    part.modelname = "contarm"
    part.compiler.degree = False
    part.compiler.autolimits = False
    for name, (rgba, specular, shininess) in _MATERIALS.items():
        part.add_material(name=name, rgba=rgba, specular=specular, shininess=shininess)
    add_defaults(part, arm)
    bodies = add_backbone(part, arm)
    add_muscles(part, arm, bodies, actuation)
    add_sensors(part)
    return part


def arm_spec(arm: Arm, actuation: Actuation = "lengths", timestep: float | None = None) -> mujoco.MjSpec:
    """Return the arm alone, ready to compile: `spec` with base at the world's origin, options and a keyframe.

    Gravity is the arm's own, in the base frame, which is the world frame here. The keyframe `straight` is an
    equilibrium without gravity. An arm whose world has a host is in that: see `Host`. Options and keyframes are then
    the host's, with the straight arm in the keyframes; the time step is less than the host's where the arm needs that.

    Args:
        actuation: as in `spec`.
        timestep: [s]; default `TIMESTEP`, or less for arms that would blow up at that.

    Raises:
        InputError: an unknown actuation, or an arm that no time step suits.
    """
    alone, host = spec(arm.alone, actuation), arm.world.host
    if host is not None:
        return _in_host(alone, arm, host, actuation, timestep)
    alone.option.timestep = timestep or longest_step(alone.compile(), arm, actuation, TIMESTEP)
    alone.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    alone.option.gravity = arm.gravity
    alone.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT  # nothing is there to touch
    joints = len(alone.joints)
    if arm.world.touchable:
        add_objects(alone, arm)
        make_touchable(alone, arm)
    straight, state = _straight(alone, arm, actuation)
    alone.add_key(name="straight", qpos=[0.0] * joints + _free(alone, arm), ctrl=straight, act=state)
    alone.stat.extent = 1.2 * arm.length
    alone.stat.center = [0.0, 0.0, 0.5 * arm.length]
    return alone


def _in_host(part: mujoco.MjSpec, arm: Arm, host: Host, actuation: Actuation, timestep: float | None) -> mujoco.MjSpec:
    """Return a host with the arm in it, ready to compile."""
    compiled = part.compile()
    step = timestep or longest_step(compiled, arm, actuation, host.read.timestep)
    joints, (straight, state) = len(part.joints), _straight(part, arm, actuation)
    whole = attach(part, arm, host)
    whole.option.timestep = step
    with adding(host):
        add_objects(whole, arm)
        place_objects(whole, arm, np.array(host.base.position), np.array(host.base.quaternion))
        add_feelers(whole, arm)
        exclude_mount(whole, arm, host)
        add_host_sensors(whole, arm)
    damp(whole, arm)
    add_keys(whole, host, [0.0] * joints, _free(whole, arm), straight, state)
    return whole


def scene_spec(arm: Arm, actuation: Actuation = "lengths") -> mujoco.MjSpec:
    """Return the arm on its mount above a floor, with light and cameras; in a host, that, and what it lacks of these.

    The base is turned by `arm.base_orientation`; if omitted, so that gravity points down the picture.

    Args:
        actuation: as in `spec`.

    Raises:
        InputError: an unknown actuation.
    """
    scene = arm_spec(arm, actuation)
    if arm.world.host is not None:
        add_to_host(scene, arm)
        add_nose(scene, arm)
        return scene
    scene.modelname = "contarm_scene"
    scene.option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    scene.option.gravity = world_gravity(arm)
    base = scene.body("base")
    base.pos = add_scene(scene, arm)
    base.quat = base_quaternion(arm)
    place_objects(scene, arm, base.pos, base.quat)
    dress_objects(scene, arm)
    add_nose(scene, arm)
    return scene


def _straight(part: mujoco.MjSpec, arm: Arm, actuation: Actuation) -> tuple[list[float], list[float]]:
    """Return the controls and the states of the actuators that hold the straight arm."""
    each = straight_controls(arm, actuation)
    straight = each * (len(part.actuators) // len(each)) if each else []
    return straight, straight if actuation != "none" and ACTUATORS[actuation].states else []


def _free(part: mujoco.MjSpec, arm: Arm) -> list[float]:
    """Return positions and orientations of the free objects, as the engine has them after the arm's joint angles."""
    bodies = [part.body(name) for name in arm.world.movable]
    return [x for body in bodies for x in (*body.pos.tolist(), *body.quat.tolist())]

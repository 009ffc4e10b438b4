"""The three muscles as spatial tendons with affine length servos, and the sensors of what a user reads."""

from __future__ import annotations

import math

import mujoco

from contarm_sim.arm import Arm

MUSCLES = ("muscle_1", "muscle_2", "muscle_3")
COLOURS = ([0.84, 0.15, 0.16, 1.0], [0.17, 0.50, 0.72, 1.0], [0.95, 0.63, 0.10, 1.0])


def add_muscles(spec: mujoco.MjSpec, arm: Arm, bodies: list[mujoco.MjsBody]) -> None:
    """Route each muscle through a site at radius r on every station and drive it by a length servo.

    force = kp (setpoint - length) - kv velocity, limited to pulling. A feed-forward tension T folds into the
    set-point: setpoint = target_length - T/kp.
    """
    kp = arm.muscle.servo_stiffness
    shortest, longest = arm.muscle_length_range
    servo = spec.add_default("muscle", spec.default)
    servo.tendon.width = 0.5 * arm.muscle.diameter
    servo.site.group = 4
    servo.site.size = [0.002, 0.002, 0.002]
    servo.actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    servo.actuator.gainprm[0] = kp
    servo.actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    servo.actuator.biasprm[:3] = [0.0, -kp, -kp * arm.muscle.servo_time]
    servo.actuator.forcerange = [-arm.muscle.blocked_force, 0.0]
    servo.actuator.forcelimited = True
    servo.actuator.ctrlrange = [shortest - arm.muscle.blocked_force / kp, longest]
    servo.actuator.ctrllimited = True
    for index, name in enumerate(MUSCLES):
        angle = 2 * math.pi * index / 3
        place = [arm.muscle_radius * math.cos(angle), arm.muscle_radius * math.sin(angle), 0.0]
        tendon = spec.add_tendon(servo, name=name, rgba=COLOURS[index])
        for body in bodies:
            site = body.add_site(servo, name=f"{body.name}_{name}", pos=place)
            tendon.wrap_site(site.name)
        spec.add_actuator(servo, name=name, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=name)


def add_sensors(spec: mujoco.MjSpec) -> None:
    """Add sensors: tip pose in the base frame, muscle lengths, velocities and forces, joint angles."""
    kind, site = mujoco.mjtSensor, mujoco.mjtObj.mjOBJ_SITE
    for name, what in (("tip_position", kind.mjSENS_FRAMEPOS), ("tip_orientation", kind.mjSENS_FRAMEQUAT)):
        spec.add_sensor(name=name, type=what, objtype=site, objname="tip", reftype=site, refname="base")
    for quantity, what in (("length", kind.mjSENS_TENDONPOS), ("velocity", kind.mjSENS_TENDONVEL)):
        for muscle in MUSCLES:
            spec.add_sensor(name=f"{muscle}_{quantity}", type=what, objtype=mujoco.mjtObj.mjOBJ_TENDON, objname=muscle)
    for muscle in MUSCLES:
        spec.add_sensor(
            name=f"{muscle}_force", type=kind.mjSENS_ACTUATORFRC, objtype=mujoco.mjtObj.mjOBJ_ACTUATOR, objname=muscle
        )
    for joint in spec.joints:
        spec.add_sensor(
            name=f"{joint.name}_angle", type=kind.mjSENS_JOINTPOS, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname=joint.name
        )


def straight_setpoint(arm: Arm) -> float:
    """Return the set-point [m] that gives the straight arm's muscles their least tension."""
    return arm.length - arm.muscle.min_tension / arm.muscle.servo_stiffness

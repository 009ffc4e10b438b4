"""The muscles of a spec: tendons, what drives them, and the sensors of what is read.

`ACTUATORS` is the only place that knows what there is to drive muscles with: another actuation is a file with its class
and a line here.
"""

from __future__ import annotations

from typing import Literal, get_args

import mujoco

from contarm_sim.errors import InputError
from contarm_sim.mjcf import names
from contarm_sim.mjcf.actuators import Actuators
from contarm_sim.mjcf.pressures import PressuredMuscles
from contarm_sim.mjcf.routing import add_tendons
from contarm_sim.mjcf.servos import LengthServos
from contarm_sim.mjcf.tensions import Tensions
from contarm_sim.model.arm import Arm

Actuation = Literal["lengths", "pressures", "tensions", "none"]
ACTUATIONS: tuple[Actuation, ...] = get_args(Actuation)

ACTUATORS: dict[Actuation, Actuators] = {
    "lengths": LengthServos(),
    "pressures": PressuredMuscles(),
    "tensions": Tensions(),
}
"""What drives the muscles; `none` is a bare backbone."""


def add_muscles(spec: mujoco.MjSpec, arm: Arm, bodies: list[mujoco.MjsBody], actuation: Actuation) -> None:
    """Add the muscles along the backbone and their actuators.

    Raises:
        InputError: an unknown actuation.
    """
    if actuation not in ACTUATIONS:
        raise InputError("actuation", repr(actuation), ", ".join(ACTUATIONS))
    if actuation == "none":
        return
    actuators = ACTUATORS[actuation]
    strands = [add_tendons(spec, arm, group, bodies, actuators.damping(group)) for group in arm.groups]
    actuators.add(spec, strands)


def stiffest(arm: Arm, actuation: Actuation) -> list[float]:
    """Return the most that each muscle's tension gains by its length [N/m]."""
    if actuation == "none":
        return []
    most = ACTUATORS[actuation].stiffest
    each = [(group, (group.law.passive_stiffness or 0.0) + most(group)) for group in arm.groups]
    return [value for group, value in each for _ in range(group.routing.count)]


def add_sensors(spec: mujoco.MjSpec) -> None:
    """Add sensors: tip pose in the base frame, muscle lengths, velocities and forces, joint angles."""
    kind, site, tendon = mujoco.mjtSensor, mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtObj.mjOBJ_TENDON
    for name, what in (
        (names.TIP_POSITION, kind.mjSENS_FRAMEPOS),
        (names.TIP_ORIENTATION, kind.mjSENS_FRAMEQUAT),
    ):
        spec.add_sensor(name=name, type=what, objtype=site, objname=names.TIP, reftype=site, refname=names.BASE)
    muscles = [tendon.name for tendon in spec.tendons]
    for quantity, what in (
        (names.LENGTH, kind.mjSENS_TENDONPOS),
        (names.VELOCITY, kind.mjSENS_TENDONVEL),
        (names.FORCE, kind.mjSENS_TENDONACTFRC),
    ):
        for muscle in muscles:
            spec.add_sensor(name=names.sensor(muscle, quantity), type=what, objtype=tendon, objname=muscle)
    for joint in spec.joints:
        spec.add_sensor(
            name=names.angle_sensor(joint.name), type=kind.mjSENS_JOINTPOS, objtype=mujoco.mjtObj.mjOBJ_JOINT,
            objname=joint.name,
        )  # fmt: skip


def straight_controls(arm: Arm, actuation: Actuation = "lengths") -> list[float]:
    """Return the controls that hold the straight arm without load, one for each muscle: [m], [Pa] or [N].

    The slackest muscle of each section has its least tension, or the lowest pressure that there is where that is more.
    Of length servos of evenly spaced muscles they are 0.

    Raises:
        InputError: an unknown actuation.
    """
    if actuation == "none":
        return []
    if actuation not in ACTUATORS:
        raise InputError("actuation", actuation, ", ".join(ACTUATIONS))
    control = ACTUATORS[actuation].straight_control
    return [control(group, share) for group in arm.groups for share in group.routing.shares]

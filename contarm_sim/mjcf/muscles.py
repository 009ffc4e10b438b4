"""What drives the three muscles, length servos, pressures or plain forces, and the sensors of what is read."""

from __future__ import annotations

import math
from typing import Any, Literal, get_args

import mujoco

from contarm_sim.errors import InputError
from contarm_sim.mjcf.routing import MUSCLES, add_tendons, counted_from
from contarm_sim.model.arm import Arm

Actuation = Literal["lengths", "pressures", "tensions", "none"]
ACTUATIONS: tuple[Actuation, ...] = get_args(Actuation)

_LINEAR, _QUADRATIC = "pressure_linear", "pressure_quadratic"

_REACH = 2.0
"""A length in rest lengths that no muscle gets to."""


def add_muscles(spec: mujoco.MjSpec, arm: Arm, bodies: list[mujoco.MjsBody], actuation: Actuation) -> None:
    """Add the muscles along the backbone and their actuators.

    Raises:
        InputError: an unknown actuation.
    """
    if actuation not in ACTUATIONS:
        raise InputError("actuation", repr(actuation), ", ".join(ACTUATIONS))
    if actuation == "none":
        return
    damping = servo_parameters(arm)[3] if actuation == "lengths" else 0.0
    muscle = add_tendons(spec, arm, bodies, damping)
    if actuation != "pressures":
        {"lengths": _servo, "tensions": _pull}[actuation](muscle.actuator, arm)
        _add_actuators(spec, muscle)
    else:
        _add_actuators(spec, _linear(spec, arm), "_linear")
        reach = [length * arm.muscle_rest_length for length in (1 - arm.muscle.max_contraction, _REACH)]
        counted = [length - counted_from(arm) for length in reach]
        _add_actuators(spec, _quadratic(spec, arm), "_quadratic", lengthrange=counted)


def _add_actuators(spec: mujoco.MjSpec, default: mujoco.MjsDefault, ending: str = "", **given: Any) -> None:
    for name in MUSCLES:
        spec.add_actuator(default, name=name + ending, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=name, **given)


def _servo(actuator: mujoco.MjsActuator, arm: Arm) -> None:
    """Make a length servo: force = kp (control - change) - least tension, limited to pulling.

    `change` is the muscle's length beyond the straight arm's, so a control of zero holds the straight arm at its least
    tension. A tension T to be had at a length change l folds into the control: l - (T - least)/kp. The servo's damping
    belongs to the tendon: as a part of a force that is limited it would vanish at the limit, and the servo would hunt
    between nothing and full force for ever.
    """
    kp, bias, control_range, _ = servo_parameters(arm)
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    actuator.gainprm[0] = kp
    actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    actuator.biasprm[:3] = bias
    actuator.forcerange = [-arm.muscle.blocked_force, 0.0]
    actuator.forcelimited = True
    actuator.ctrlrange = control_range
    actuator.ctrllimited = True


def servo_parameters(arm: Arm) -> tuple[float, list[float], tuple[float, float], float]:
    """Return a length servo's gain [N/m], biases, range of controls [m] and the damping along its muscle [N s/m]."""
    kp = arm.servo_stiffness
    straight = kp * (arm.length - counted_from(arm))
    return kp, [straight - arm.muscle.min_tension, -kp, 0.0], arm.setpoint_range, kp * arm.servo_time


def _pull(actuator: mujoco.MjsActuator, arm: Arm) -> None:
    """Make a plain force: the control is the tension, at most the blocked force."""
    blocked = arm.muscle.blocked_force
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    actuator.gainprm[0] = -1.0
    actuator.forcerange = [-blocked, 0.0]
    actuator.forcelimited = True
    actuator.ctrlrange = [0.0, blocked]
    actuator.ctrllimited = True


# The McKibben force P A (c s^2 - d), s = L/L_rest, vanishes at s0, where c s0^2 = d; there it is, exactly,
#     P A (2 c s0 (s - s0) + c (s - s0)^2)        for s > s0, and nothing below: a muscle cannot push.
# Native gains are affine in length, or made of parabolas (those of biological muscles); so two actuators make a
# muscle, both fed with its pressure: the line, limited to pulling, and the parabola, which is zero below its vertex.


def _linear(spec: mujoco.MjSpec, arm: Arm) -> mujoco.MjsDefault:
    """Make the line 2 c s0 (s - s0) of the McKibben law."""
    default = spec.add_default(_LINEAR, spec.default)
    _valve(default.actuator, arm)
    rest, s0 = arm.muscle_rest_length, 1 - arm.muscle.max_contraction
    slope = 2 * s0 * _pull_per_pascal(arm) / rest
    default.actuator.gaintype = mujoco.mjtGain.mjGAIN_AFFINE
    default.actuator.gainprm[:2] = [slope * (s0 * rest - counted_from(arm)), -slope]
    default.actuator.forcerange = [-10 * slope * rest * arm.muscle.max_pressure, 0.0]  # never met from below
    default.actuator.forcelimited = True
    return default


def _quadratic(spec: mujoco.MjSpec, arm: Arm) -> mujoco.MjsDefault:
    """Make the parabola c (s - s0)^2 of the McKibben law.

    The engine's muscle gain is -F (x/x1)^2 / 2 from its shortest length, x = 0, to x1, half its range; a speed limit
    that is never met turns its dependence on velocity off.
    """
    default = spec.add_default(_QUADRATIC, spec.default)
    _valve(default.actuator, arm)
    force = 2 * _pull_per_pascal(arm) * (_REACH - (1 - arm.muscle.max_contraction)) ** 2
    shortest, longest, most_speed = 0.0, 2.0, 1e9
    default.actuator.gaintype = mujoco.mjtGain.mjGAIN_MUSCLE
    default.actuator.gainprm[:9] = [0.0, 0.5, force, 1.0, shortest, longest, most_speed, 1.0, 1.0]
    return default


def _valve(actuator: mujoco.MjsActuator, arm: Arm) -> None:
    """Let pressure [Pa] follow its command with a first-order lag."""
    actuator.dyntype = mujoco.mjtDyn.mjDYN_FILTEREXACT
    actuator.dynprm[0] = arm.muscle.valve_time
    actuator.ctrlrange = [0.0, arm.muscle.max_pressure]
    actuator.ctrllimited = True


def _pull_per_pascal(arm: Arm) -> float:
    """Return A c [m^2], the braid's share of the force at rest length, per unit of pressure."""
    return math.pi * arm.muscle.diameter**2 / 4 * 3 / math.tan(arm.muscle.braid_angle) ** 2


def stiffest(arm: Arm, actuation: Actuation) -> float:
    """Return the most that a muscle's tension gains by its length [N/m]."""
    silicone = arm.muscle.passive_stiffness or 0.0
    if actuation == "lengths":
        return silicone + arm.servo_stiffness
    if actuation != "pressures":
        return silicone
    longest = 1 + arm.muscle.max_stretch
    return silicone + arm.muscle.max_pressure * 2 * _pull_per_pascal(arm) * longest / arm.muscle_rest_length


def add_sensors(spec: mujoco.MjSpec) -> None:
    """Add sensors: tip pose in the base frame, muscle lengths, velocities and forces, joint angles."""
    kind, site, tendon = mujoco.mjtSensor, mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtObj.mjOBJ_TENDON
    for name, what in (("tip_position", kind.mjSENS_FRAMEPOS), ("tip_orientation", kind.mjSENS_FRAMEQUAT)):
        spec.add_sensor(name=name, type=what, objtype=site, objname="tip", reftype=site, refname="base")
    muscles = [tendon.name for tendon in spec.tendons]
    for quantity, what in (
        ("length", kind.mjSENS_TENDONPOS),
        ("velocity", kind.mjSENS_TENDONVEL),
        ("force", kind.mjSENS_TENDONACTFRC),
    ):
        for muscle in muscles:
            spec.add_sensor(name=f"{muscle}_{quantity}", type=what, objtype=tendon, objname=muscle)
    for joint in spec.joints:
        spec.add_sensor(
            name=f"{joint.name}_angle", type=kind.mjSENS_JOINTPOS, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname=joint.name
        )


def straight_control(arm: Arm, actuation: Actuation = "lengths") -> float:
    """Return the control that gives the straight arm's muscles their least tension: [m], [Pa] or [N].

    Of length servos it is 0. The pressure is at least the lowest that there is, so tensions may be larger.
    """
    muscle = arm.muscle
    if actuation == "lengths":
        return 0.0
    if actuation == "tensions":
        return muscle.min_tension
    s, s0 = 1 - muscle.mount_contraction, 1 - muscle.max_contraction
    return max(muscle.min_tension / (_pull_per_pascal(arm) * (s**2 - s0**2)), muscle.min_pressure)

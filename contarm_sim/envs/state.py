"""What is seen of arms, whatever simulates them: named quantities in SI units, with a leading axis of arms.

    quantity            size     unit   scaled by
    muscle_lengths      n        m      (L - straight) / (pi r), r once for each section that the muscle runs through
    muscle_velocities   n        m/s    1 m/s
    actuator_tensions   n        N      blocked force; what the actuators pull with, pulling > 0
    pressures           n        Pa     highest pressure; only where pressures drive the arm
    joint_angles        dofs     rad    pi / links of the section
    tip_position        3        m      L0; in the base frame
    tip_orientation     4        -      1; quaternion w x y z in the base frame
    section_ends        3 (S-1)  m      L0; in the base frame; of all sections but the last, which ends in the tip

n is the number of muscles, S that of sections, L0 the length of the whole arm. Tensions are those of the engine's last
step, 5 ms before the rest, without the servos' damping along the muscles.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.envs.ranges import half_turn
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.muscles import bend_of_lengths, evenly_spaced
from contarm_sim.mechanics import muscles, routing
from contarm_sim.mjcf import names
from contarm_sim.mjcf.routing import counted_from
from contarm_sim.model.arm import Arm

State = dict[str, Array]

ENGINE_FIELDS = ("ten_length", "ten_velocity", "actuator_force", "act", "qpos", "sensordata")
"""Fields of the engine's data that a state is read from."""


def read(source: Any, arm: Arm) -> State:
    """Return the state of arms like this one from arrays with a leading axis, (B, ...), named as `ENGINE_FIELDS`.

    Sensors are those of `add_end_sensors`, the tip's pose first, the ends of sections last.
    """
    force, sensors = source["actuator_force"], source["sensordata"]
    count, ends = muscles.count(arm), 3 * (len(arm.sections) - 1)
    state = {
        "muscle_lengths": source["ten_length"] + muscles.each(arm, counted_from),
        "muscle_velocities": source["ten_velocity"],
        "actuator_tensions": -force if force.shape[-1] == count else -(force[..., :count] + force[..., count:]),
    }
    if source["act"].shape[-1]:
        state["pressures"] = source["act"][..., :count]
    state["joint_angles"] = source["qpos"][..., : joint_count(arm)]
    state["tip_position"], state["tip_orientation"] = sensors[..., :3], sensors[..., 3:7]
    if ends:
        state["section_ends"] = sensors[..., -ends:]
    return state


def end_sensors(arm: Arm) -> list[str]:
    """Return the names of the sensors of where sections but the last end."""
    return [f"{names.of_section(arm, number)}{names.TIP_POSITION}" for number in range(len(arm.sections) - 1)]


def add_end_sensors(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Add sensors of where sections but the last end, in the base frame."""
    stations, starts = names.stations(arm), names.section_stations(arm)
    for number, name in enumerate(end_sensors(arm)):
        spec.add_sensor(
            name=name, type=mujoco.mjtSensor.mjSENS_FRAMEPOS, objtype=mujoco.mjtObj.mjOBJ_XBODY,
            objname=stations[starts[number + 1]], reftype=mujoco.mjtObj.mjOBJ_SITE, refname=names.BASE,
        )  # fmt: skip


def joint_count(arm: Arm) -> int:
    """Return the number of joint angles, which come first among the engine's positions."""
    return sum((2 if part.torsional_stiffness is None else 3) * part.links for part in arm.sections)


def sizes(arm: Arm) -> dict[str, int]:
    """Return how many numbers each quantity of a state has."""
    of_tip = {
        "joint_angles": joint_count(arm),
        "tip_position": 3,
        "tip_orientation": 4,
        "section_ends": 3 * len(arm.sections) - 3,
    }
    return {name: of_tip.get(name, muscles.count(arm)) for name in scales(arm)}


def scales(arm: Arm) -> dict[str, tuple[Any, Any]]:
    """Return (offset, scale) of every quantity of a state: what is observed is (value - offset) / scale.

    Each is one number, or one for each of the quantity's.
    """
    angles = [
        np.full((2 if section.torsional_stiffness is None else 3) * section.links, np.pi / section.links)
        for section in arm.sections
    ]
    found = {
        "muscle_lengths": (muscles.each(arm, lambda group: group.length), muscles.each(arm, half_turn)),
        "muscle_velocities": (0.0, 1.0),
        "actuator_tensions": (0.0, muscles.each(arm, lambda group: group.law.blocked_force)),
        "pressures": (0.0, muscles.each(arm, lambda group: group.law.pressure_limits[1])),
        "joint_angles": (0.0, np.concatenate(angles)),
        "tip_position": (0.0, arm.length),
        "tip_orientation": (0.0, 1.0),
    }
    return found if len(arm.sections) == 1 else found | {"section_ends": (0.0, arm.length)}


def bend_shown(lengths: Array, arm: Arm) -> Array:
    """Return the bends [rad], shape (..., 2 S), that muscle lengths, or changes of them [m], shape (..., n), show.

    As those of arcs, by their differences alone; of one section's evenly spaced muscles term by term.
    """
    if len(arm.sections) == 1 and evenly_spaced(arm.routing.angles):
        return bend_of_lengths(lengths, arm.routing.radius, arm.routing.angles)
    return routing.bend_from_arc_deltas(lengths, arm)[0]

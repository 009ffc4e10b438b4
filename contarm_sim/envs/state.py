"""What is seen of arms, whatever simulates them: named quantities in SI units, with a leading axis of arms.

    quantity            size   unit   scaled by
    muscle_lengths      3      m      (L - L0) / (pi r)
    muscle_velocities   3      m/s    1 m/s
    actuator_tensions   3      N      blocked force; what the actuators pull with, pulling > 0
    pressures           3      Pa     highest pressure; only where pressures drive the arm
    joint_angles        dofs   rad    pi / links
    tip_position        3      m      L0; in the base frame
    tip_orientation     4      -      1; quaternion w x y z in the base frame

Tensions are those of the engine's last step, 5 ms before the rest, without the servos' damping along the muscles.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf.routing import counted_from
from contarm_sim.model.arm import Arm

State = dict[str, Array]

ENGINE_FIELDS = ("ten_length", "ten_velocity", "actuator_force", "act", "qpos", "sensordata")
"""Fields of the engine's data that a state is read from."""


def read(source: Any, arm: Arm) -> State:
    """Return the state of arms like this one from arrays with a leading axis, (B, ...), named as `ENGINE_FIELDS`."""
    force, sensors = source["actuator_force"], source["sensordata"]
    state = {
        "muscle_lengths": source["ten_length"] + counted_from(arm.group),
        "muscle_velocities": source["ten_velocity"],
        "actuator_tensions": -force if force.shape[-1] == 3 else -(force[..., :3] + force[..., 3:]),
    }
    if source["act"].shape[-1]:
        state["pressures"] = source["act"][..., :3]
    state["joint_angles"] = source["qpos"]
    state["tip_position"], state["tip_orientation"] = sensors[..., :3], sensors[..., 3:7]
    return state


def scales(arm: Arm) -> dict[str, tuple[float, float]]:
    """Return (offset, scale) of every quantity of a state: what is observed is (value - offset) / scale."""
    return {
        "muscle_lengths": (arm.length, np.pi * arm.muscle_radius),
        "muscle_velocities": (0.0, 1.0),
        "actuator_tensions": (0.0, arm.muscle.blocked_force),
        "pressures": (0.0, arm.muscle.pressure_limits[1]),
        "joint_angles": (0.0, np.pi / arm.links),
        "tip_position": (0.0, arm.length),
        "tip_orientation": (0.0, 1.0),
    }

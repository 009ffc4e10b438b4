"""How stiff the tip is: a small force at the tip either way, and how far the tip yields."""

from __future__ import annotations

import mujoco
import numpy as np

from contarm_sim.engine.moved import STATE
from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

FORCE = 0.05
"""Force of the probe [N]."""

STEP = 0.0025
"""Engine step [s]."""

SETTLING, RISING = 1.5, 0.5
"""Time for the arm to come to rest under the force, and for the force to rise [s]."""


def tip_stiffness(arm: Arm, qpos: Array, control: Array) -> Array:
    """Return force by displacement of the tip along X, Y and Z of the base frame [N/m], shape (3,).

    Args:
        arm: in its world.
        qpos: joint angles that it starts from [rad], shape (dofs,).
        control: controls of its length servos, kept [m], shape (n,).
    """
    plant = Plant(arm, timestep=STEP, in_world=arm.world.touchable)
    plant.restart(qpos, control)
    _settle(plant, np.zeros(3))
    rest = np.empty(mujoco.mj_stateSize(plant.model, STATE))
    mujoco.mj_getState(plant.model, plant.data, rest, STATE)
    found = np.empty(3)
    for axis, unit in enumerate(np.eye(3)):
        ends = []
        for force in (FORCE * unit, -FORCE * unit):
            mujoco.mj_setState(plant.model, plant.data, rest, STATE)
            _settle(plant, force)
            ends.append(plant.tip)
        found[axis] = 2 * FORCE / abs((ends[0] - ends[1])[axis])
    return found


def _settle(plant: Plant, force: Array) -> None:
    """Let the arm come to rest under a force at its tip [N], shape (3,)."""
    for step in range(round(SETTLING / STEP)):
        plant.data.xfrc_applied[plant.index.tip, :3] = force * min(1.0, step * STEP / RISING)
        mujoco.mj_step(plant.model, plant.data)
    plant.data.xfrc_applied[plant.index.tip, :3] = 0.0
    mujoco.mj_forward(plant.model, plant.data)

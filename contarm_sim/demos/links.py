"""Where a link is, of recorded joint angles."""

from __future__ import annotations

import mujoco
import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm


def link_poses(arm: Arm, qpos: Array, station: int) -> tuple[Array, Array]:
    """Return places [m], shape (T, 3), and orientations, shape (T, 3, 3), of the link at a station.

    Args:
        qpos: joint angles [rad], shape (T, dofs).
        station: counted from the base, 0 to the number of links.
    """
    plant = Plant(arm.alone)
    places, turns = np.empty((len(qpos), 3)), np.empty((len(qpos), 3, 3))
    for row, angles in enumerate(qpos):
        plant.data.qpos[:] = angles
        mujoco.mj_kinematics(plant.model, plant.data)
        places[row], turns[row] = plant.centres[station], plant.rotations[station]
    return places, turns

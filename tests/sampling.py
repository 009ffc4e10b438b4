"""What several tests need: bends with the singular cases, an arm with all there is, a plant's forces differenced."""

import mujoco
import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.mechanics.pneumatics import passive_tension
from contarm_sim.model.arm import Arm
from contarm_sim.model.mckibben import McKibben

HEAVY = Arm(
    links=9, payload=0.2, torsional_stiffness=0.03, gravity=(1.0, 2.0, 9.0), length=1 / 3, joint_friction=1 / 700,
    muscle=McKibben(passive_stiffness=1e3 / 7, braid_friction=1 / 3, valve_time=1 / 30),
)  # fmt: skip


def bends(count: int, seed: int = 0, largest: float = np.pi) -> np.ndarray:
    """Random bends [rad] that always include straight, near straight, near pi, and both singular planes."""
    rng = np.random.default_rng(seed)
    third = count // 10
    angle = np.concatenate(
        [
            rng.uniform(0, largest, count - 2 * third),
            10.0 ** rng.uniform(-12, -1, third),
            np.nextafter(largest, 0) - 10.0 ** rng.uniform(-9, -1, third),
        ]
    )
    angle[:4] = 0.0, 1e-12, 1e-9, np.nextafter(largest, 0) - 1e-9
    plane = rng.uniform(-np.pi, np.pi, count)
    plane[::7] = 0.0
    plane[1::7] = np.pi / 2
    plane[2::7] = np.pi
    return arc.from_polar(angle, plane)


def _by_twist(plant) -> np.ndarray | float:
    """Return what the engine's forces lack of twisted muscles [N m]: T dL/dq of helices, not stiffer springs."""
    if plant.twisted is None:
        return 0.0
    arm = plant.arm
    engine = plant.actuator_tensions + passive_tension(plant.data.ten_length + arm.length, arm)
    straight = plant.twisted.__dict__["_by_angle"]
    springs = (plant.model.jnt_stiffness - plant.springs) * plant.data.qpos
    return springs + engine @ straight - plant.muscle_tensions @ plant.muscle_jacobian


def differenced_stiffness(plant) -> np.ndarray:
    """Return -dQ/dq [N m/rad] at a plant's pose by central differences of the engine's forces, twisted muscles' too."""
    model, data = plant.model, plant.data
    at, step, columns = data.qpos.copy(), 1e-6, []
    for j in range(model.nv):
        forces = []
        for sign in (1, -1):
            data.qpos[:] = at
            data.qpos[j] += sign * step
            mujoco.mj_forward(model, data)
            forces.append(data.qfrc_smooth + _by_twist(plant))
        columns.append((forces[1] - forces[0]) / (2 * step))
    return np.stack(columns, axis=1)

"""Lean: the arm leans on a wall, and its tip is stiffer for it."""

from __future__ import annotations

import mujoco
import numpy as np

from contarm_sim.demos.demonstration import STEP, Demonstration, OnTick, Requirement, ticks
from contarm_sim.demos.files import arm_of, knots_of, smooth
from contarm_sim.engine.moved import STATE
from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import CONTROL_RATE, Stepping, simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.results.touched import object_forces

FORCE = 0.05
"""Force at the tip, either way, that tells how stiff it is [N]."""

SETTLING, RISING = 1.5, 0.5
"""Time for the arm to come to rest under the force, and for the force to rise [s]."""


def demonstrate(on_tick: OnTick | None = None) -> Demonstration:
    """Simulate the same controls with the wall and without, and compare how stiff the tip is at the end."""
    arm = arm_of("lean")
    times, angles = knots_of("lean")
    time = np.arange(round(times[-1] * CONTROL_RATE) + 1) / CONTROL_RATE
    bend = np.zeros((len(time), 4))
    bend[:, 0::2] = smooth(times, angles, time)
    reference = Reference.from_bends(bend, arm, time)
    motions = [
        simulate(one, reference, "feedforward", stepping=Stepping(STEP), on_tick=ticks(on_tick, number, len(time)))
        for number, one in enumerate((arm, arm.alone))
    ]
    leaning, free = motions
    assert leaning.contacts is not None
    stiff, slack = (tip_stiffness(each.arm, each.qpos[-1], each.setpoint[-1]) for each in motions)
    ratio = stiff / slack
    pressed = float(np.linalg.norm(object_forces(leaning.contacts, len(leaning))[-1], axis=-1).sum())
    deepest = float(leaning.contacts.depth.max(initial=0.0))
    checks = [
        Requirement("net force of the wall at the end", pressed, 0.2, "N", least=True),
        Requirement("deepest contact of a link", deepest, 0.0005, "m"),
        *(Requirement(f"tip stiffness along {axis}, leaning over free", float(ratio[i]), least, "", least=True)
          for i, (axis, least) in enumerate((("X", 3.0), ("Y", 3.0), ("Z", 1.2)))),
    ]  # fmt: skip
    said = (
        f"the tip's stiffness is {slack[0]:.0f} N/m across the wall and {slack[1]:.0f} N/m along it when free, "
        f"{stiff[0]:.0f} and {stiff[1]:.0f} N/m when the arm leans: between base and wall it can hardly move, and only "
        "what is beyond bends"
    )
    return Demonstration(leaning, checks, said, free, ("leaning on the wall", "the same controls, no wall"),
                         camera=(-84.0, 5.0))  # fmt: skip


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

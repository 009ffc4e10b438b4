"""Cost of contact: a step of an arm that touches something, over a free step of the same arm; accuracy of its forces.

Processor time of one thread, best of interleaved repeats, all in one run. `Plant(arm, in_world=True)` steps and feels
as `contarm run` does; without objects it is the free arm. What contact forces lack is measured beside Newton's method
run to the end on the same states.
"""

import time
from dataclasses import replace

import mujoco
import numpy as np

from contarm_sim import Arm
from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.model.objects import Object
from contarm_sim.model.presets import two

REPEATS, STEPS = 25, 250

POST = Object(name="post", shape="cylinder", radius=0.02, length=0.3, position=(0.055, 0, 0.2), axis=(0, 1, 0))
FAR = replace(POST, position=(2.0, 0.0, 0.2))
CAN = replace(POST, radius=0.03, length=0.12, position=(0.075, 0.0, 0.22))
ROD = replace(CAN, shape="capsule")
LEANING = {1: (-0.03, 0.015, 0.015), 2: (-0.03, 0.015, 0.015, -0.02, 0.01, 0.01)}
WRAPPED = (-0.0126, 0.0063, 0.0063, -0.0338, 0.0169, 0.0169)


def at_rest(arm, lengths, seconds=6.0):
    """Return an arm that has been driven to length changes [m], touching what is in the way."""
    plant = Plant(arm, in_world=True)
    plant.reset()
    for _ in range(round(seconds / plant.model.opt.timestep)):
        plant.data.ctrl[:] = np.array(lengths) * min(1.0, plant.data.time / 2.0)
        mujoco.mj_step(plant.model, plant.data)
    return plant


def cost(plants):
    """Return the least microseconds a step of each of several arms."""
    least = np.full(len(plants), np.inf)
    with engine_room():
        for _ in range(REPEATS):
            for place, plant in enumerate(plants):
                start = time.process_time()
                mujoco.mj_step(plant.model, plant.data, STEPS)
                least[place] = min(least[place], (time.process_time() - start) / STEPS)
    return 1e6 * least


def forces(model, data):
    """Return the contact forces [N], shape (C, 3), normal first."""
    found, one = np.zeros((data.ncon, 3)), np.zeros(6)
    for contact in range(data.ncon):
        mujoco.mj_contactForce(model, data, contact, one)
        found[contact] = one[:3]
    return found


def missing(arm, lengths):
    """Return what contact forces lack of converged ones, over the largest of each state, while an arm closes."""
    plant = Plant(arm, in_world=True)
    model, data = plant.model, plant.data
    exact = Plant(arm, in_world=True)
    exact.model.opt.tolerance, exact.model.opt.iterations, exact.model.opt.ls_iterations = 1e-15, 500, 500
    plant.reset()
    lacking = []
    for step in range(800):
        data.ctrl[:] = np.array(lengths) * min(1.0, data.time / 2.0)
        for name in ("qpos", "qvel", "ctrl", "qacc_warmstart"):
            getattr(exact.data, name)[:] = getattr(data, name)
        mujoco.mj_step(model, data)
        if step % 5 == 0 and data.ncon:
            mujoco.mj_forward(exact.model, exact.data)
            there = forces(exact.model, exact.data)
            lacking.append(np.abs(forces(model, data) - there).max() / max(0.1, np.abs(there).max()))
    return np.percentile(lacking, [50, 99, 100])


def main():
    for name, arm in (("24 links", Arm()), ("two sections of 12 links", two())):
        leaning = LEANING[len(arm.sections)]
        cases = [
            ("far from a cylinder", replace(arm, objects=(FAR,)), leaning),
            ("against a cylinder", replace(arm, objects=(POST,)), leaning),
        ]
        if len(arm.sections) == 2:
            arm = replace(arm, gravity=(0.0, 0.0, 0.0))
            cases.append(("around a capsule", replace(arm, objects=(ROD,)), WRAPPED))
            cases.append(("around a cylinder", replace(arm, objects=(CAN,)), WRAPPED))
        itself = arm.in_world(replace(arm.world, self_contact=True))
        cases.append(("free, self-contact on", itself, leaning))
        plants = [at_rest(arm, leaning), *(at_rest(each, lengths) for _, each, lengths in cases)]
        for plant in plants[1:]:  # one that feels nothing, for the cost of sensors
            twin = Plant(plant.arm, in_world=True)
            twin.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SENSOR
            twin.data.qpos[:], twin.data.qvel[:] = plant.data.qpos, plant.data.qvel
            twin.data.ctrl[:], twin.data.qacc_warmstart[:] = plant.data.ctrl, plant.data.qacc_warmstart
            plants.append(twin)
        spent = cost(plants)
        print(f"{name}: a free step {spent[0]:.1f} us")
        for place, (case, _, _) in enumerate(cases):
            ratio, without = spent[1 + place] / spent[0], spent[1 + len(cases) + place] / spent[0]
            points = plants[1 + place].data.ncon
            print(f"  {case}, {points} contacts: {ratio:.2f} of a free step ({without:.2f} without any sensors)")
    wrapping = replace(two(), gravity=(0.0, 0.0, 0.0), objects=(CAN,))
    median, most, worst = missing(wrapping, WRAPPED)
    print(f"contact forces around a cylinder lack {median:.0e} (median), {most:.0e} (99 %), {worst:.0e} (all)")


if __name__ == "__main__":
    main()

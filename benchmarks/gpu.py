"""Arms times steps a second on a GPU, beside the processor's `Batch` on all its cores, in the same run.

The default arm of 24 links, driven by lengths, each with a bending stiffness of its own; controls of a second of motion
are known beforehand. The table is of the device that it names: with a CUDA device 256 to 65,536 arms; without one
Warp's processor device, which is there to test with, at small counts. The last column says that it is the same motion.

With `--agreement` instead: how far three arms of each kind are from the processor's engine, in double precision.

    python benchmarks/gpu.py [--links N] [--arms N ...] [--agreement]
"""

import argparse
import os
import time

import mujoco
import numpy as np
from mujoco.batch import Batch

from contarm_sim import Arm
from contarm_sim.engine.models import built
from contarm_sim.engine.plants import Plants
from contarm_sim.engine.room import engine_room
from contarm_sim.engine.warp import WarpPlants
from contarm_sim.engine.warp_batch import WarpBatch
from contarm_sim.engine.warp_library import described, on_cuda
from contarm_sim.model.presets import two

ON_GPU, ON_PROCESSOR = (256, 1024, 4096, 16384, 65536), (16, 64, 256)
AT_ONCE, ROUNDS = 25, 8
"""Steps that go to the device in one graph; how many of these are timed, after one that is not."""

KINDS = {
    "length servos": ({}, "lengths"),
    "tensions": ({}, "tensions"),
    "pressures": ({}, "pressures"),
    "muscles in straight spans": ({"path": "spans"}, "lengths"),
    "a backbone that twists": ({"torsional_stiffness": 0.5}, "lengths"),
    "two sections, six muscles": (None, "lengths"),
    "dry friction in the joints": ({"joint_friction": 0.002}, "lengths"),
}
PULLS = {"lengths": -0.004, "tensions": 8.0, "pressures": 1e5}

MOST_ON_PROCESSOR = 1024
"""Arms of the processor's batch: its rate does not depend on more."""


def controls(model, count):
    """Return controls of all steps, shape (rounds + 1, steps, count, nu) [m]."""
    ticks = np.arange((ROUNDS + 1) * AT_ONCE)
    one = -0.004 * np.arange(model.nu) * (1 - np.cos(0.05 * ticks))[:, None]
    return np.broadcast_to(one[:, None], (len(ticks), count, model.nu)).reshape(ROUNDS + 1, AT_ONCE, count, model.nu)


def springs(model, count):
    """Return stiffnesses of joints [N m/rad], shape (count, joints), of the first arms the same whatever the count."""
    return model.jnt_stiffness * (1 + 0.3 * np.sin(np.arange(count)))[:, None]


def rate(advance, given, arms):
    """Return arms times steps a second."""
    advance(given[0])
    start = time.perf_counter()
    for some in given[1:]:
        advance(some)
    return arms * AT_ONCE * ROUNDS / (time.perf_counter() - start)


def on_device(model, count):
    batch = WarpBatch(model, count)
    tips = batch.bind("xpos")
    batch.reset(keyframe=0)
    batch.write("jnt_stiffness", springs(model, count))
    return rate(batch.roll, controls(model, count), count), tips[:, -1]


def on_processor(model, count):
    batch = Batch(model, count, len(os.sched_getaffinity(0)))
    batch.expand("jnt_stiffness")[:] = springs(model, count)
    control, tips = batch.bind("ctrl"), batch.bind("xpos")
    batch.reset(keyframe=0)

    def advance(some):
        for sent in some:
            control[:] = sent
            batch.step()

    return rate(advance, controls(model, count), count), tips[:, -1]


def off(given, actuation, links):
    """Return by how much joint angles differ after one step [rad], and tips after 1 s [mm]."""
    hanging = {"links": links, "gravity": (0.3, 0, -9.81)}
    arms = [Arm(payload=0.02 * k, **hanging, **given) for k in (1, 2, 3)] if given is not None else [two()] * 3
    both, first = (WarpPlants(arms, actuation), Plants(arms, actuation)), []
    for plants in both:
        count, muscles = plants.zero.shape
        plants.restart(None, np.zeros((count, plants.models[0].nq)), np.zeros((count, muscles)))
        for tick in range(200):
            plants.stiffen_twist()
            plants.send(
                np.tile(PULLS[actuation] * (np.arange(muscles) % 3) * (1 - np.cos(0.05 * (tick + 30))), (count, 1))
            )
            plants.step()
            if not tick:
                first.append(plants.qpos.copy())
        plants.forward()
    return np.abs(first[0] - first[1]).max(), 1e3 * np.linalg.norm(both[0].tip - both[1].tip, axis=-1).max()


def agreement(links):
    print("| arms | joint angles after one step | tip after 1 s |")
    print("|---|---:|---:|")
    for name, (given, actuation) in KINDS.items():
        angle, tip = off(given, actuation, links)
        print(f"| {name} | {angle:.0e} rad | {tip:.0e} mm |", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--agreement", action="store_true")
    parser.add_argument("--links", type=int, default=24)
    parser.add_argument("--arms", type=int, nargs="+", default=ON_GPU if on_cuda() else ON_PROCESSOR)
    given = parser.parse_args()
    model, cores = built(Arm(links=given.links), "lengths").model, len(os.sched_getaffinity(0))
    print(f"{described()}; MuJoCo {mujoco.__version__} on {cores} cores; {given.links} links, {model.nv} joint angles")
    if given.agreement:
        with engine_room():
            return agreement(given.links)
    print("| arms | Warp, arms x steps/s | processor, arms x steps/s | ratio | largest difference of tips |")
    print("|---:|---:|---:|---:|---:|")
    for count in given.arms:
        with engine_room():
            ours, tips = on_device(model, count)
            theirs, others = on_processor(model, min(count, MOST_ON_PROCESSOR))
        apart = 1e3 * np.abs(tips[: len(others)] - others).max()
        print(f"| {count:,} | {ours:,.0f} | {theirs:,.0f} | {ours / theirs:.2f} | {apart:.0e} mm |", flush=True)
    if not on_cuda():
        print("No CUDA device was found: these are figures of Warp's processor device, which say nothing of a GPU.")


if __name__ == "__main__":
    main()

"""Cost of the vector environment: against bare `Batch.step` calls, and against a loop over single environments.

All three step the same arms through whole episodes of `reach`, resets included, under the same actions. They take turns
within one run; ratios are of neighbouring turns, their median and range.

Then arms of one, two and three sections of as many links each: environment steps a second of the native vector, and
microseconds a degree of freedom and engine step of one thread.

Then every task under its baseline, in processor time of one thread: `grasp` with its log and forks, and its arm alone
in `reach`, under the same actions.
"""

import os
import time

import gymnasium
import mujoco
import numpy as np
from mujoco.batch import Batch

import contarm_sim.envs.gym  # noqa: F401
from contarm_sim.envs.baseline import baseline
from contarm_sim.envs.definition import TASKS, define
from contarm_sim.envs.vector import ArmVectorEnv
from contarm_sim.model.arm import Arm
from contarm_sim.model.section import Section

ARMS, THREADS, ROUNDS = 256, len(os.sched_getaffinity(0)), 5
definition = define("reach")
TICKS = definition.ticks + 1  # an episode and the step that resets


def bare():
    """Return a function that steps a batch, without anything around it."""
    batch = Batch(definition.built(definition.arm).model, ARMS, THREADS, persistent=True)
    control = batch.bind("ctrl")
    batch.reset(keyframe=0)

    def run(actions):
        for action in actions:
            control[:] = action
            batch.step(None, definition.substeps)

    return run


def wrapped(mode, **given):
    """Return a function that steps environments."""
    envs = gymnasium.make_vec("contarm/Reach-v0", ARMS, vectorization_mode=mode, **given)
    envs.reset(seed=0)

    def run(actions):
        for action in actions:
            envs.step(action)

    return run


def by_sections(count=64, links=12):
    """Print what steps cost of arms of one, two and three sections; they take turns."""
    sections = tuple(Section(length=length, links=links, mass=0.1) for length in (0.2, 0.17, 0.12))
    arms = [Arm(sections=sections[:number]) for number in (1, 2, 3)]
    made = [gymnasium.make_vec("contarm/Reach-v0", count, vectorization_mode="vector_entry_point", arm=arm, threads=1)
            for arm in arms]  # fmt: skip
    took, rng = [[] for _ in arms], np.random.default_rng(0)
    for _ in range(ROUNDS):
        for envs, spent in zip(made, took, strict=True):
            envs.reset(seed=0)
            actions = rng.uniform(-1, 1, (20, *envs.action_space.shape))
            start = time.perf_counter()
            for action in actions:
                envs.step(action)
            spent.append((time.perf_counter() - start) / (20 * count))
    for number, (envs, spent) in enumerate(zip(made, took, strict=True), 1):
        one = float(np.median(spent))
        dofs, substeps = envs.definition.sizes["joint_angles"], envs.definition.substeps
        each = 1e6 * one / (dofs * substeps)
        print(f"{number} sections of {links} links, {dofs} dofs: {1 / one:6.0f} steps/s, {each:.2f} us a dof and step")


def episode(envs, policy, ticks):
    """Step arms under a policy; print and return processor time of an engine step [us], and the actions."""
    (observation, _), spent, actions = envs.reset(seed=0), 0.0, []
    for _ in range(ticks):
        actions.append(policy(observation))
        start = time.process_time()
        observation = envs.step(actions[-1])[0]
        spent += time.process_time() - start
    steps, definition = ticks * envs.num_envs, envs.definition
    one = 1e6 * spent / (steps * definition.substeps)
    dofs, objects = definition.sizes["joint_angles"], len(definition.arm.world.objects)
    what = f"{definition.task.name}, {objects} objects, {dofs} dofs"
    print(f"{what}: {steps / spent:.0f} steps/s, {one:.0f} us an engine step")
    return one, actions


def by_task(count=8, ticks=140):
    """Print what steps cost of every task, the baseline's own arithmetic aside."""
    for name in TASKS:
        envs = ArmVectorEnv(count, threads=1, task=name)
        touching, actions = episode(envs, baseline(envs.definition), ticks)
    alone = ArmVectorEnv(count, threads=1, task="reach", arm=envs.definition.arm.alone, actions="lengths", time_limit=8)
    same = iter(alone.definition.actions.asking(envs.definition.actions.controls(each)) for each in actions)
    print(f"the last over its arm alone: {touching / episode(alone, lambda _: next(same), ticks)[0]:.2f} x")


def main() -> None:
    rng = np.random.default_rng(0)
    actions = rng.uniform(-1, 1, (TICKS, ARMS, 2))
    controls = [definition.actions.controls(action) for action in actions]
    runs = {
        "bare Batch.step": (bare(), controls),
        "native vector": (wrapped("vector_entry_point", threads=THREADS), actions),
        "SyncVectorEnv": (wrapped("sync"), actions),
    }
    took = {name: [] for name in runs}
    for _ in range(ROUNDS):
        for name, (run, given) in runs.items():
            start = time.perf_counter()
            run(given)
            took[name].append(time.perf_counter() - start)
    print(f"{ARMS} arms, {THREADS} threads, mujoco {mujoco.__version__}")
    for name, values in took.items():
        print(f"{name:16} {ARMS * TICKS / np.median(values):8.0f} steps/s")
    bare_took, native, loop = (np.array(values) for values in took.values())
    for what, ratios in (("native vector over bare", native / bare_took), ("SyncVectorEnv over native", loop / native)):
        print(f"time of {what}: {np.median(ratios):.2f} x ({ratios.min():.2f} to {ratios.max():.2f})")
    by_sections()
    by_task()


if __name__ == "__main__":
    main()

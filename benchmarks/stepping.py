"""Cost of the stepping loop with controller and recording over a bare `mj_step` loop: same model, motion and steps."""

import time

import mujoco
import numpy as np

from contarm_sim import Arm, paths
from contarm_sim.kinematics import dome
from contarm_sim.simulation.plant import Plant
from contarm_sim.simulation.run import ACCURATE, FAST, simulate

DURATION, RATE, REPEATS = 5.0, 100.0, 9


def bare(arm, samples, stepping):
    """Replay the recorded set-points, one step a call, with nothing else in the loop."""
    plant = Plant(arm, timestep=stepping.timestep)
    plant.data.qpos[:] = samples.qpos[0]
    model, data = plant.model, plant.data
    substeps = stepping.substeps(RATE)
    start = time.perf_counter()
    for setpoint in samples.setpoint:
        data.ctrl[:] = setpoint
        for _ in range(substeps):
            mujoco.mj_step(model, data)
    return time.perf_counter() - start


def main():
    arm = Arm()
    _, targets = paths.named("spiral", arm.length, duration=DURATION).targets(RATE)
    bend = dome.bend_from_tip(targets, arm.length).bend
    for name, stepping in (("default", ACCURATE), ("--fast", FAST)):
        ratios, factors = [], []
        for _ in range(REPEATS):
            run = simulate(arm, targets, bend, stepping=stepping)
            alone = bare(arm, run.samples, stepping)
            ratios.append(DURATION / run.real_time_factor / alone)
            factors.append(run.real_time_factor)
        print(
            f"{name:8} step {1e3 * stepping.timestep:4.1f} ms: loop over bare mj_step {np.median(ratios):.3f} "
            f"({min(ratios):.3f} to {max(ratios):.3f}); {np.median(factors):.0f} x real time"
        )


if __name__ == "__main__":
    main()

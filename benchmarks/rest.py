"""One corrected pose at rest by Newton, over letting the arm swing out under the same set-point."""

import time

import mujoco
import numpy as np

from contarm_sim import Arm, poses_at_rest
from contarm_sim.engine.plant import Plant
from contarm_sim.paths.reference import Reference
from contarm_sim.studies.scenarios import dome_grid


def main():
    for name, arm in {"no gravity": Arm(), "hanging": Arm(gravity=(0, 0, 9.81))}.items():
        bend = dome_grid(5)
        reference = Reference.from_bends(bend, arm)
        poses_at_rest(arm, Reference.from_bends(bend[:3], arm))
        start = time.perf_counter()
        samples = poses_at_rest(arm, reference)
        newton = (time.perf_counter() - start) / len(bend)
        swings = []
        for i in range(1, len(bend), 15):
            plant = Plant(arm)
            plant.reset(bend[i])
            plant.data.ctrl[:] = samples.setpoint[i]
            start = time.perf_counter()
            while np.linalg.norm(plant.tip - samples.stations[i, -1]) > 1e-9 and plant.data.time < 60:
                mujoco.mj_step(plant.model, plant.data, 10)
            swings.append(time.perf_counter() - start)
        print(
            f"{name:12} Newton {1e3 * newton:.2f} ms a pose, set-points found with it; swinging out to 1 nm "
            f"{1e3 * np.median(swings):.0f} ms: {np.median(swings) / newton:.0f} times as long"
        )


if __name__ == "__main__":
    main()

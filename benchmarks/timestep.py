"""The time step's own error along the spiral, against ten times finer stepping: what the default step rests on."""

import mujoco
import numpy as np

from contarm_sim import Arm, paths
from contarm_sim.errors import DivergenceError
from contarm_sim.motion.simulate import Stepping, simulate
from contarm_sim.paths.reference import Reference

STEPS = (0.001, 0.002, 0.005, 0.01)
INTEGRATORS = {
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "discrete": mujoco.mjtIntegrator.mjINT_DISCRETE,
}


def main():
    arms = {"no gravity": Arm(), "hanging with 100 g": Arm(gravity=(0, 0, 9.81), payload=0.1)}
    print("largest tip error of the step alone along the default spiral [% of length]; times real time")
    for name, arm in arms.items():
        spiral = Reference.from_path(paths.named("spiral", arm.length), arm)
        finest = simulate(arm, spiral, stepping=Stepping(0.0001)).tip
        for label, integrator in INTEGRATORS.items():
            for step in STEPS:
                reference = finest
                if label == "implicitfast":
                    reference = simulate(arm, spiral, stepping=Stepping(step / 10)).tip
                try:
                    run = simulate(arm, spiral, stepping=Stepping(step, integrator))
                except DivergenceError as error:
                    print(f"{name:20} {label:13} {1e3 * step:5.1f} ms  diverged at {error.time:.2f} s")
                    continue
                error = np.linalg.norm(run.tip - reference, axis=-1).max() / arm.length
                print(f"{name:20} {label:13} {1e3 * step:5.1f} ms  {100 * error:8.4f} %  {run.real_time_factor:6.0f} x")


if __name__ == "__main__":
    main()

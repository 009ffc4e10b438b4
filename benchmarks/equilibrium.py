"""Time to a static pose under random loads, over letting the arm settle by stepping and over SciPy's root finder."""

import time

import mujoco
import numpy as np
from scipy.optimize import root

from contarm_sim import Arm
from contarm_sim.load import Load, Muscles, Wrench
from contarm_sim.simulation.equilibrium import driven_plant, equilibrium
from contarm_sim.simulation.plant import engine_room
from contarm_sim.simulation.solver import Solver


def case(rng, links):
    arm = Arm(links=links, gravity=tuple(rng.normal(size=3) * 4))
    force = rng.normal(size=3) * arm.bending_stiffness / arm.length**2
    muscles = Muscles(kind="bend", values=(rng.uniform(0, 2), rng.uniform(-3, 3))) if rng.random() < 0.5 else Muscles()
    return arm, Load(wrenches=(Wrench(xi=rng.random(), force=tuple(force)),), muscles=muscles)


def prepared(arm, load):
    plant = driven_plant(arm, load)
    return plant, Solver(plant, load)


def by_stepping(arm, load, tip):
    plant, solver = prepared(arm, load)
    start = time.perf_counter()
    while plant.data.time < 30:
        for _ in range(20):
            plant.data.qfrc_applied[:] = solver.load.generalised_forces()
            mujoco.mj_step(plant.model, plant.data)
        if np.linalg.norm(plant.tip - tip) < 1e-7:
            break
    return time.perf_counter() - start


def by_scipy(arm, load):
    plant, solver = prepared(arm, load)

    def forces(qpos):
        plant.data.qpos[:] = qpos
        solver.evaluate()
        return solver.forces

    start = time.perf_counter()
    root(forces, plant.data.qpos.copy(), method="hybr", tol=1e-10)
    return time.perf_counter() - start


def main():
    for links in (24, 50):
        rng = np.random.default_rng(1)
        ours, steps, scipy = [], [], []
        with engine_room():
            for i in range(60):
                arm, load = case(rng, links)
                found = equilibrium(arm, load)
                ours.append(found.seconds)
                if i < 12:
                    steps.append(by_stepping(arm, load, found.tip) / found.seconds)
                    scipy.append(by_scipy(arm, load) / found.seconds)
        low, middle, high = 1e3 * np.quantile(ours, [0.05, 0.5, 0.95])
        print(
            f"{links} links: {middle:.2f} ms a pose (5 to 95 %: {low:.2f} to {high:.2f}); stepping to 0.1 um takes "
            f"{np.median(steps):.0f} times as long, scipy.optimize.root {np.median(scipy):.0f} times"
        )


if __name__ == "__main__":
    main()

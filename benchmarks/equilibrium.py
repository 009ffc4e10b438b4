"""Time to a static pose under random loads, beside a bare step of the engine, stepping to rest and SciPy's root finder.

Times are of this process's own processor, so that others on the machine do not count; quantiles are 5, 50 and 95 %.
"""

import time

import mujoco
import numpy as np
from scipy.optimize import root

from contarm_sim import Arm
from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.mjcf import arm_spec
from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.statics.equilibrium import driven_plant, equilibrium
from contarm_sim.statics.extrapolation import extrapolated
from contarm_sim.statics.solver import Solver


def case(rng, links):
    arm = Arm(links=links, gravity=tuple(rng.normal(size=3) * 4))
    force = rng.normal(size=3) * arm.bending_stiffness / arm.length**2
    muscles = Muscles(kind="bend", values=(rng.uniform(0, 2), rng.uniform(-3, 3))) if rng.random() < 0.5 else Muscles()
    return arm, Load(wrenches=(Wrench(xi=rng.random(), force=tuple(force)),), muscles=muscles)


def timed(function, *given):
    start = time.process_time()
    function(*given)
    return 1e3 * (time.process_time() - start)


def compiled(links):
    arm_spec(Arm(links=links)).compile()


def solve(arm, load):
    """Solve on a model that is there."""
    plant, solver = prepared(arm, load)
    start = time.process_time()
    solver.newton()
    solver.positive()
    return 1e3 * (time.process_time() - start), plant.tip


def prepared(arm, load):
    plant = driven_plant(arm, load)
    return plant, Solver(plant, load)


def by_stepping(arm, load, tip):
    plant, solver = prepared(arm, load)
    while plant.data.time < 30:
        for _ in range(20):
            plant.data.qfrc_applied[:] = solver.load.generalised_forces()
            mujoco.mj_step(plant.model, plant.data)
        if np.linalg.norm(plant.tip - tip) < 1e-7:
            break


def by_scipy(arm, load):
    plant, solver = prepared(arm, load)

    def forces(qpos):
        plant.data.qpos[:] = qpos
        solver.evaluate()
        return solver.forces

    root(forces, plant.data.qpos.copy(), method="hybr", tol=1e-10)


def said(times):
    low, middle, high = np.quantile(times, [0.05, 0.5, 0.95])
    return f"{middle:.2f} ms ({low:.2f} to {high:.2f})"


def main():
    for links in (12, 24, 50):
        rng = np.random.default_rng(1)
        cases = [case(rng, links) for _ in range(60)]
        plant = Plant(Arm(links=links))
        with engine_room():
            for arm, load in cases[:4]:
                extrapolated(arm, load)
            step = np.median([timed(mujoco.mj_step, plant.model, plant.data, 50) / 50 for _ in range(20)])
            compiling = np.median([timed(compiled, links) for _ in range(10)])
            kept = [solve(*each) for each in cases]
            whole = [timed(equilibrium, *each) for each in cases]
            twice = [timed(extrapolated, *each) for each in cases]
            slow = [timed(by_stepping, *each, tip) for each, (_, tip) in zip(cases[:8], kept, strict=False)]
            scipy = [timed(by_scipy, *each) for each in cases[:8]]
        solving = [one for one, _ in kept]
        print(
            f"{links} links: solving {said(solving)}, {np.median(solving) / step:.0f} steps of the engine; a call "
            f"{said(whole)}, extrapolated {said(twice)}; building the model alone takes {compiling:.2f} ms, "
            f"scipy.optimize.root {np.median(scipy) / np.median(whole):.0f} times as long as a call, stepping to rest "
            f"{np.median(slow) / np.median(whole):.0f} times"
        )


if __name__ == "__main__":
    main()

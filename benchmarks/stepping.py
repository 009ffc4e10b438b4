"""Cost of stepping: the loop, controller and recording included, over bare `mj_step`; a step by links.

Processor time of one thread, so that other work on the machine disturbs it less; medians of interleaved repeats.
Between machines and hours the loop's ratio still varies by a few percent, that of single repeats by a fifth.
"""

import time

import mujoco
import numpy as np

from contarm_sim import Arm, Section, paths
from contarm_sim.control.servo import Servo
from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.engine.recorder import Recorder
from contarm_sim.model.presets import two
from contarm_sim.motion.simulate import CONTROL_RATE, simulate
from contarm_sim.motion.stepping_loop import Pass
from contarm_sim.paths.reference import Reference

DURATION, REPEATS = 2.0, 25
LINKS = (6, 12, 24, 48, 96)


def bare(plant, controls, substeps):
    """Replay recorded controls, one step a call, with nothing else in the loop."""
    model, data = plant.model, plant.data
    start = time.process_time()
    for control in controls:
        data.ctrl[:] = control
        for _ in range(substeps):
            mujoco.mj_step(model, data)
    return time.process_time() - start


def loop(arm, substeps):
    """Return the ratios of the loop to the bare steps of the same motion."""
    spiral, servo = Reference.from_path(paths.named("spiral", arm.length, DURATION, turns=0.4), arm), Servo()
    plan = servo.plan(arm, spiral)
    controls = simulate(arm, spiral).setpoint
    plant, ratios = Plant(arm, timestep=1 / (CONTROL_RATE * substeps)), []
    recorder = Recorder(plant, len(spiral))
    with engine_room():
        for _ in range(REPEATS):
            plant.restart(np.zeros(plant.model.nq), plan.start)
            one = Pass(
                plant, plan, servo.checked_limits(arm), servo.feedback(arm, spiral, plan), CONTROL_RATE, substeps
            )
            start = time.process_time()
            one.run(recorder, 0, len(spiral))
            spent = time.process_time() - start
            plant.restart(np.zeros(plant.model.nq), plan.start)
            ratios.append(spent / bare(plant, controls, substeps))
    return np.array(ratios)


def steps(arms, count=1500):
    """Return microseconds a step of each of several arms, and a way to drive them, taken in turn."""
    plants, spent = [Plant(arm, actuation=actuation) for arm, actuation in arms], []
    for plant in plants:
        plant.reset(np.array([1.0, 0.5]))
    with engine_room():
        for _ in range(9):
            row = []
            for plant in plants:
                start = time.process_time()
                mujoco.mj_step(plant.model, plant.data, count)
                row.append(1e6 * (time.process_time() - start) / count)
            spent.append(row)
    return np.median(spent, axis=0)


def by_sections():
    """Print what steps of several sections cost beside one of as many links, and the loop of two over bare ones."""
    for count in (2, 3):
        sections = tuple(Section(length=0.37 / count, links=24, mass=0.3 / count) for _ in range(count))
        several, one = steps([(Arm(sections=sections), "lengths"), (Arm(links=24 * count), "lengths")], 800)
        print(f"a step of {count} sections of 24 links: {several / one:.2f} of one section of {24 * count} links")
    low, middle, high = np.percentile(loop(two(), 2), [25, 50, 75])
    print(f"two sections, six muscles: loop over bare mj_step {middle:.3f} (quartiles {low:.3f} to {high:.3f})")


def main():
    for name, substeps in (("default, 5 ms", 2), ("--fast, 10 ms", 1)):
        ratios = loop(Arm(), substeps)
        low, middle, high = np.percentile(ratios, [25, 50, 75])
        print(f"{name}: loop over bare mj_step {middle:.3f} (quartiles {low:.3f} to {high:.3f})")
    parallel, straight, free = steps([(Arm(), "lengths"), (Arm(path="spans"), "lengths"), (Arm(), "none")])
    print(
        f"a step at 24 links: parallel muscles {parallel / straight:.2f}, none {free / straight:.2f} of straight spans"
    )
    cost = steps([(Arm(links=links), "lengths") for links in LINKS], 400)
    exponent = np.polyfit(np.log(LINKS), np.log(cost), 1)[0]
    shown = ", ".join(f"{links}: {c:.1f}" for links, c in zip(LINKS, cost, strict=True))
    print(
        f"microseconds a step by links: {shown}; exponent {exponent:.2f}, {np.log2(cost[-1] / cost[-2]):.2f} at the end"
    )
    by_sections()


if __name__ == "__main__":
    main()

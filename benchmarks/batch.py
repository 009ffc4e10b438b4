"""Cost of many arms at once: 256 of them with controller, feedback and recording, over the bare `Batch.step` loop.

Ratios of interleaved repeats: processor time of the loop over that of the bare steps with the same controls; clock time
of one thread over that of two, beside the processor time, which tells whether the machine was idle. And whether arms
have the bits that each has alone.
"""

import sys
import time
from dataclasses import replace

import numpy as np

from contarm_sim import Arm, paths, simulate, simulate_many
from contarm_sim.control.servo import Servo
from contarm_sim.engine.plants import Plants
from contarm_sim.engine.room import engine_room
from contarm_sim.motion.legs import Formation
from contarm_sim.motion.simulate import Stepping
from contarm_sim.motion.step_search import Motion
from contarm_sim.motion.time_step import ACCURATE
from contarm_sim.paths.reference import Reference

ARMS, DURATION, REPEATS, SUBSTEPS = 256, 0.25, 5, 2


def motions(count):
    """Return arms of different stiffness, mass, damping and gravity, and a spiral."""
    rng, arm = np.random.default_rng(0), Arm()
    arms = [
        replace(arm, bending_stiffness=0.1 * (1 + b), mass=0.3 * (1 + m), gravity=(0, 0, 9.81 * g))
        for b, m, g in rng.uniform(0, 0.5, (count, 3))
    ]
    return arms, Reference.from_path(paths.named("spiral", arm.length, DURATION, turns=0.05), arm)


def timed(work):
    """Return clock and processor time [s] of a call, and what it returns."""
    clock, spent = time.perf_counter(), time.process_time()
    found = work()
    return time.perf_counter() - clock, time.process_time() - spent, found


def loop(arms, reference, threads):
    """Return the times of the loop, and what it sent, shape (ticks, B, n)."""
    legs = [next(Motion(arm, reference, Servo(), ACCURATE).run(SUBSTEPS)) for arm in arms]
    formation = Formation(legs, Plants.of([leg.one.plant for leg in legs], threads))
    clock, spent, flown = timed(formation.fly)
    assert all(hasattr(one, "recorder") for one in flown)
    return clock, spent, np.stack([leg.one.setpoint for leg in legs], axis=1)


def bare(arms, reference, controls, threads):
    """Return the times of as many bare steps from the same start, with nothing else in the loop."""
    legs = [next(Motion(arm, reference, Servo(), ACCURATE).run(SUBSTEPS)) for arm in arms]
    batch = Plants.of([leg.one.plant for leg in legs], threads).batch
    ctrl = batch.bind("ctrl")

    def step():
        for control in controls:
            ctrl[:] = control
            for _ in range(SUBSTEPS):
                batch.step()

    return timed(step)[:2]


def main():
    arms, reference = motions(ARMS)
    rows = []
    with engine_room():
        for _ in range(REPEATS):
            two, one = loop(arms, reference, 2), loop(arms, reference, 1)
            rows.append((one[1] / bare(arms, reference, one[2], 1)[1], one[0] / two[0], one[0] / one[1]))
    over, faster, waited = np.median(rows, axis=0)
    print(f"{ARMS} arms, {arms[0].links} links: loop over bare Batch.step {over:.3f} (processor time, one thread)")
    print(f"two threads over one: {faster:.2f} x (clock); clock over processor time of one thread {waited:.2f}")
    some = arms[:: ARMS // 16]
    same = all(
        np.array_equal(many.stations, alone.stations) and np.array_equal(many.muscle_tensions, alone.muscle_tensions)
        for many, alone in zip(
            simulate_many(some, reference, stepping=Stepping()),
            (simulate(arm, reference, stepping=Stepping()) for arm in some),
            strict=True,
        )
    )
    print(f"{len(some)} of them have the bits that each has alone: {same}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())

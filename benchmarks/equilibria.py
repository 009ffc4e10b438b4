"""Static poses in bulk: over their bare arithmetic, over `equilibrium` one by one, on two threads, and many of them.

The bare arithmetic is what no Newton can leave out: forces, stiffness matrix and `numpy.linalg.solve` for every step of
every pose; as these calls take it, on arrays of many cases, and one pose after the other. Times are of this process's
own processor, the best of several repeats, taken in turns; those of two threads are of the clock.
"""

import time

import numpy as np

from contarm_sim import Arm, Load, Muscles, Wrench, equilibria, equilibrium
from contarm_sim.engine.plant import engine_room
from contarm_sim.statics.cases import BUNCH
from contarm_sim.statics.driving import driven_plant
from contarm_sim.statics.equilibrium import reused
from contarm_sim.statics.solver import Solver
from contarm_sim.statics.stiffness import TangentStiffness
from contarm_sim.statics.together import Together

REPEATS, POSES, BEFORE = 7, 5 * BUNCH, 11.9
"""`BEFORE`: a call of `equilibrium` of version 0.1.0 [ms]."""

ARM = Arm(gravity=(0.0, 0.0, 9.81))


def loads(kind, count, rng):
    values = {
        "off": lambda: (),
        "bend": lambda: (rng.uniform(0, 2), rng.uniform(-3, 3)),
        "tensions": lambda: tuple(rng.uniform(0, 30, 3)),
        "pressures": lambda: tuple(rng.uniform(90e3, 500e3, 3)),
    }[kind]
    scale = ARM.bending_stiffness / ARM.length**2
    return [
        Load(
            wrenches=(Wrench(xi=rng.random(), force=tuple(scale * rng.normal(size=3))),),
            muscles=Muscles(kind=kind, values=values()),
        )
        for _ in range(count)
    ]


def bare(function):
    """Return a call's time, and that of forces, stiffness matrices and solutions in it, of steps alone [s]."""
    spent, rows = {"evaluate": 0.0, "matrix": 0.0, "solve": 0.0}, {"matrix": 0, "solve": 0}
    plain = Together._evaluate, TangentStiffness.matrix, np.linalg.solve

    def watched(name, of):
        def call(*given):
            start = time.process_time()
            found = of(*given)
            spent[name] += time.process_time() - start
            if name in rows:
                rows[name] += len(found)
            return found

        return call

    Together._evaluate, TangentStiffness.matrix = watched("evaluate", plain[0]), watched("matrix", plain[1])
    np.linalg.solve = watched("solve", plain[2])
    try:
        total = timed(function)
    finally:
        Together._evaluate, TangentStiffness.matrix, np.linalg.solve = plain
    share = rows["solve"] / rows["matrix"]  # the matrix of a pose at rest tells whether it stays: no step takes it
    return total, spent["evaluate"] + share * spent["matrix"] + spent["solve"]


def one_by_one(cases):
    """Return the time [s] of Newton's steps of one pose after the other, on a plant that is there."""
    spent = 0.0
    for load in cases:
        solver = Solver(driven_plant(ARM, load, reused), load)
        spent += timed(solver.newton)
    return spent


def timed(function, clock=time.process_time):
    start = clock()
    function()
    return clock() - start


def best(*functions, clock=time.process_time):
    return np.min([[timed(each, clock) for each in functions] for _ in range(REPEATS)], axis=0)


def main():
    rng = np.random.default_rng(0)
    for kind in ("off", "bend", "tensions", "pressures"):
        given = loads(kind, POSES, rng)
        few = given[:60]
        with engine_room():
            equilibria(ARM, few)
            ratios, times, steps, calls = [], [], [], []
            for _ in range(REPEATS):
                total, arithmetic = bare(lambda given=given: equilibria(ARM, given))
                ratios.append(total / arithmetic)
                times.append(total / POSES)
                steps.append(one_by_one(few) / len(few))
                calls.append(timed(lambda few=few: [equilibrium(ARM, load) for load in few]) / len(few))
        pose, step, call = 1e3 * min(times), 1e3 * min(steps), 1e3 * min(calls)
        print(
            f"{kind}: {pose:.3f} ms a pose, {np.median(ratios):.2f} of its arithmetic on arrays of all cases, "
            f"{pose / step:.2f} of the same steps one pose after the other; {call / pose:.1f} times faster than a call "
            f"of equilibrium, {BEFORE / pose:.0f} times than before",
            flush=True,
        )
    given = loads("bend", 20 * BUNCH, rng)
    one, two = best(lambda: equilibria(ARM, given), lambda: equilibria(ARM, given, threads=2), clock=time.perf_counter)
    print(f"two threads: {one / two:.2f} times faster by the clock (of use on an idle machine only)")
    many = loads("bend", 10_000, rng)
    start = time.perf_counter(), time.process_time()
    equilibria(ARM, many, threads=2)
    print(
        f"10,000 poses: {time.perf_counter() - start[0]:.1f} s by the clock on two threads, "
        f"{time.process_time() - start[1]:.1f} s of processors"
    )


if __name__ == "__main__":
    main()

"""Inverse kinematics of two sections to a tip position: solved, misses and times, beside scipy's least squares.

Targets are tips of random poses within the limits; solved means a miss of at most 1e-13 m for us, and of 1e-9 m for
`least_squares` (from one random start, analytic Jacobian, bends not limited). Times are of the process, not of the
clock, the best of a few runs, because the machine may be busy; "alone" is one target a call.
"""

import sys
import time
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from contarm_sim.kinematics import inverse, sections
from contarm_sim.kinematics.inverse.choices import CHOICES

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from two_targets import BACKBONES, KINDS, poses

MANY, FEW, ALONE, STARTS, REPEATS = 20_000, 5_000, 100, 100, 3


def seconds(function):
    start = time.process_time()
    result = function()
    return time.process_time() - start, result


def best(function, count):
    runs = [seconds(function) for _ in range(REPEATS)]
    return min(taken for taken, _ in runs) / count, runs[0][1]


def row(name, count, solved, miss, each, alone=None):
    last = "" if alone is None else f"{1e3 * alone:8.2f} ms"
    print(f"{name:44} {count:7d} {100 * solved:9.3f} % {miss:10.1e} m {1e6 * each:9.1f} us {last}", flush=True)


def ours(name, given, backbone, choose, alone=False):
    targets, axes = sections.position(given, backbone), sections.transform(given, backbone)[:, :3, 2]

    def solve(i):
        if choose == "direction":
            return inverse.solve(targets[i], backbone, axes[i])
        return inverse.solve(targets[i], backbone, choose=choose, near=given[i] if choose == "nearest" else None)

    each, found = best(lambda: solve(slice(None)), len(targets))
    miss = np.linalg.norm(sections.position(found.bends, backbone) - targets, axis=-1)
    one = best(lambda: [solve(i) for i in range(ALONE)], ALONE)[0] if alone else None
    row(f"{name}, {choose}", len(targets), np.mean(miss <= 1e-13), miss.max(), each, one)


def theirs(name, given, backbone):
    targets, rng = sections.position(given, backbone), np.random.default_rng(9)
    starts = poses(backbone, "random", len(targets), 8)[rng.permutation(len(targets))].reshape(-1, 4)

    def solve(target, start):
        return least_squares(
            lambda b: sections.position(b.reshape(2, 2), backbone, check=False) - target,
            start,
            jac=lambda b: sections.jacobian(b.reshape(2, 2), backbone, check=False)[:3],
            xtol=1e-15, ftol=1e-15, gtol=1e-15,
        ).x.reshape(2, 2)  # fmt: skip

    taken, found = seconds(lambda: np.array([solve(*x) for x in zip(targets, starts, strict=True)]))
    miss = np.linalg.norm(sections.position(found, backbone, check=False) - targets, axis=-1)
    within = np.all(np.hypot(found[..., 0], found[..., 1]) <= backbone.limits, axis=-1)
    row(f"{name}, least_squares", len(targets), np.mean((miss <= 1e-9) & within), miss.max(), taken / len(targets))


def unreachable(backbone):
    points = np.random.default_rng(7).normal(size=(FEW, 3))
    points *= 1.2 * backbone.length / np.linalg.norm(points, axis=-1, keepdims=True)
    each, found = best(lambda: inverse.solve(points, backbone), FEW)
    row("arcs, nearest point of what is out of reach", FEW, np.mean(~found.reachable), found.miss.max(), each)


def main():
    print(f"{'problem':44} {'targets':>7} {'solved':>11} {'worst miss':>12} {'a target':>12} {'alone':>11}")
    arcs = BACKBONES["arcs"]
    for choose in (*CHOICES, "direction"):
        ours("arcs, random", poses(arcs, "random", MANY), arcs, choose, alone=True)
    for kind in KINDS[1:]:
        ours(f"arcs, {kind}", poses(arcs, kind, FEW), arcs, "least-bend")
    for name in list(BACKBONES)[1:]:
        ours(f"{name}, random", poses(BACKBONES[name], "random", FEW), BACKBONES[name], "least-bend")
    unreachable(arcs)
    theirs("arcs, random", poses(arcs, "random", STARTS), arcs)


if __name__ == "__main__":
    main()

"""Three sections: how many random poses are solved, how well, and in what time; beside least squares from one start.

Poses are made from random bends, so that each has a solution; "own" counts those whose own bends are among the answers.
Times are of the processor, which other work on the machine changes little.
"""

import time

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from contarm_sim.kinematics import inverse, sections
from contarm_sim.kinematics.backbone import LARGEST, Backbone

MANY, NEAR, ALONE, FEW = 100_000, 10_000, 300, 100
LENGTHS = (0.2, 0.17, 0.15)
ARMS = {
    "arcs": Backbone(lengths=LENGTHS),
    "long in the middle": Backbone(lengths=(0.1, 0.3, 0.1)),
    "tapering": Backbone(lengths=(0.3, 0.1, 0.05)),
    "chains of 6, 12 and 3 joints": Backbone(lengths=LENGTHS, links=(6, 12, 3)),
}


def bends(count, low=0.0, high=LARGEST, seed=0):
    rng = np.random.default_rng(seed)
    angle, plane = rng.uniform(low, high, (count, 3)), rng.uniform(-np.pi, np.pi, (count, 3))
    return angle[..., None] * np.stack([np.cos(plane), np.sin(plane)], axis=-1)


def row(name, count, solved, own, miss, seconds):
    print(f"{name:48} {count:7d} {100 * solved:8.3f} {100 * own:8.3f} {miss:9.1e} {1e6 * seconds:10.0f}", flush=True)


def poses(name, b, backbone):
    T = sections.transform(b, backbone)
    position, rotation = T[:, :3, 3].copy(), T[:, :3, :3].copy()
    start = time.process_time()
    found, count = inverse.all_poses(position, rotation, backbone)
    seconds = (time.process_time() - start) / len(b)
    apart = np.abs(found - b[:, None]).max(axis=(-1, -2))
    own = np.where(np.isnan(apart), np.inf, apart).min(axis=1) < 1e-6
    known = np.isfinite(found[..., 0, 0])
    reached = sections.transform(found[known], backbone)
    of = np.nonzero(known)[0]
    miss = np.abs(reached[:, :3, 3] - position[of]).max()
    turned = 0.3 * backbone.length * np.abs(reached[:, :3, :3] - rotation[of]).max()
    row(name, len(b), np.mean(count > 0), own.mean(), max(miss, turned), seconds)
    return count


def alone(backbone):
    b = bends(ALONE, seed=3)
    T = sections.transform(b, backbone)
    seconds = []
    for each in T:
        start = time.process_time()
        inverse.solve(each[:3, 3], backbone, rotation=each[:3, :3])
        seconds.append(time.process_time() - start)
    answer = inverse.solve(T[:, :3, 3], backbone, rotation=T[:, :3, :3])
    row("arcs, each alone", ALONE, answer.reachable.mean(), np.nan, answer.miss.max(), np.median(seconds))


def direction(backbone):
    T = sections.transform(bends(FEW, seed=4), backbone)
    start = time.process_time()
    answer = inverse.solve(T[:, :3, 3], backbone, T[:, :3, 2])
    seconds = (time.process_time() - start) / FEW
    row("arcs, position and direction, least bend", FEW, answer.reachable.mean(), np.nan, answer.miss.max(), seconds)


def one_start(backbone):
    """SciPy's least squares from one random start, within a box of the limits."""
    solved, worst, b = 0, 0.0, bends(FEW, seed=5)
    start = time.process_time()
    for number, each in enumerate(sections.transform(b, backbone)):

        def off(x, each=each):
            T = sections.transform(x.reshape(3, 2), backbone, check=False)
            turn = Rotation.from_matrix(T[:3, :3] @ each[:3, :3].T).as_rotvec()
            return np.concatenate([(T[:3, 3] - each[:3, 3]) / backbone.length, 0.3 * turn])

        first = bends(1, seed=100 + number).ravel()
        found = least_squares(off, first, bounds=(-LARGEST - 1e-9, LARGEST + 1e-9), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        angle = np.hypot(*found.x.reshape(3, 2).T)
        if np.linalg.norm(found.fun) < 1e-9 and angle.max() <= LARGEST:
            solved, worst = solved + 1, max(worst, np.abs(found.fun).max() * backbone.length)
    row("arcs, scipy least squares, one start", FEW, solved / FEW, np.nan, worst, (time.process_time() - start) / FEW)


def main():
    print(f"{'':48} targets solved % own, % worst [m]  [us each]")
    for name, backbone in ARMS.items():
        count = poses(name, bends(MANY, seed=1), backbone)
        poses(f"{name}, near limits", bends(NEAR, 0.95 * LARGEST, seed=2), backbone)
        if name == "arcs":
            share = np.bincount(count) / len(count)
            print("    solutions a pose: " + ", ".join(f"{k}: {100 * x:.2f} %" for k, x in enumerate(share) if x))
    arcs = ARMS["arcs"]
    alone(arcs)
    direction(arcs)
    one_start(arcs)


if __name__ == "__main__":
    main()

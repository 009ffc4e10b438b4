"""Inverse kinematics of 3 to 6 sections and tracking: success, misses and times beside two usual ways.

Each problem is solved for reachable targets, made by random bends within the limits (0.98 pi):

- `contarm`: `inverse.solve`, the choice of least total bend included.
- `least squares`: scipy.optimize.least_squares with the same Jacobian from one random start; no choice.
- `restarts`: damped least squares with up to 30 random starts, one after the other, filtered by the limits.

Times are processor times of this process a target, so that they mean the same on a busy machine.
"""

import time

import numpy as np
from scipy.optimize import least_squares

from contarm_sim.kinematics import inverse, sections
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.goals import Goals

LENGTHS = (0.2, 0.17, 0.15, 0.12, 0.1, 0.1)
COUNT, FEW, STARTS = 2000, 40, 30
PROBLEMS = [
    *(("position", count) for count in (3, 4, 5, 6)),
    *(("direction", count) for count in (3, 4)),
    *(("rotation", count) for count in (4, 5, 6)),
]


def random_bends(rng, count, size, limit=0.98 * np.pi):
    angle, plane = np.sqrt(rng.uniform(0, 1, (count, size))) * limit, rng.uniform(-np.pi, np.pi, (count, size))
    return np.stack([angle * np.cos(plane), angle * np.sin(plane)], axis=-1)


def targets(bends, backbone, what):
    T = sections.transform(bends, backbone)
    turn = {"position": {}, "direction": {"direction": T[:, :3, 2]}, "rotation": {"rotation": T[:, :3, :3]}}
    return {"position": T[:, :3, 3], **turn[what]}


def by_scipy(goals, backbone, start):
    """Return which of the goals scipy solves from one start."""
    shape = start.shape[1:]

    def terms(x, goal):
        residual, slopes = goal.terms(x.reshape(1, *shape), backbone)
        return residual[0], slopes[0]

    found = np.empty_like(start)
    for i in range(len(goals)):
        goal = goals.take([i])
        done = least_squares(
            lambda x, g=goal: terms(x, g)[0], start[i].ravel(), lambda x, g=goal: -terms(x, g)[1],
            xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=200,
        )  # fmt: skip
        found[i] = done.x.reshape(shape)
    return goals.solved(found, backbone)


def by_restarts(goals, backbone, rng):
    left = np.arange(len(goals))
    for _ in range(STARTS):
        start = random_bends(rng, len(left), len(backbone))
        own = goals.take(left)
        left = left[~own.solved(descend(own, backbone, start, limited=0.0), backbone)]
        if not len(left):
            break
    return 1 - len(left) / len(goals)


def timed(function):
    start = time.process_time()
    return function(), time.process_time() - start


def main():
    rng = np.random.default_rng(0)
    print(f"{COUNT} reachable targets each (least squares: the first {FEW}); success, worst miss [m], us a target")
    print(f"{'problem':22} {'contarm':>30} {'least squares':>20} {'restarts':>20}")
    for what, size in PROBLEMS:
        backbone = Backbone(lengths=LENGTHS[:size])
        asked = targets(random_bends(rng, COUNT, size), backbone, what)
        goals = Goals(**asked)
        answer, ours = timed(lambda a=asked, b=backbone: inverse.solve(**a, backbone=b))
        few, start = goals.take(slice(0, FEW)), random_bends(rng, FEW, size)
        good, theirs = timed(lambda f=few, b=backbone, s=start: by_scipy(f, b, s))
        share, restarts = timed(lambda g=goals, b=backbone: by_restarts(g, b, rng))
        print(
            f"{what + ', ' + str(size) + ' sections':22} {answer.reachable.mean():8.2%} {answer.miss.max():10.1e}"
            f" {1e6 * ours / COUNT:10.0f} {good.mean():9.1%} {1e6 * theirs / FEW:10.0f}"
            f" {share:9.2%} {1e6 * restarts / COUNT:10.0f}",
            flush=True,
        )
    print("\npaths of 1000 targets with a known continuous course: jumps, ms a target")
    for what, size in (("position", 2), ("direction", 2), ("position", 3), ("direction", 3), ("rotation", 3)):
        backbone, t = Backbone(lengths=LENGTHS[:size]), np.linspace(0, 2 * np.pi, 1000)[:, None, None]
        bends = rng.normal(size=(size, 2)) + np.sin(t) * rng.normal(size=(size, 2))
        bends = bends + 0.5 * np.cos(2 * t) * rng.normal(size=(size, 2))
        bends *= 0.95 * np.pi / np.linalg.norm(bends, axis=-1).max()
        asked = {f"{name}s": value for name, value in targets(bends, backbone, what).items()}
        track, seconds = timed(lambda a=asked, b=backbone: inverse.track(**a, backbone=b))
        print(f"{what + ', ' + str(size) + ' sections':22} {len(track.jumps):8d} {seconds:10.3f}", flush=True)


if __name__ == "__main__":
    main()

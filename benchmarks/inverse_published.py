"""Inverse kinematics beside what is published, on the same random reachable targets: a table in Markdown.

Targets are tips of random bends within the limits (0.98 pi). A target counts as solved if all bends returned for it are
within the limits, to 1e-11 rad, and their tips miss by at most 1e-9 of the arm's length, angles as their arc at 0.3 of
it; beside it stands how many come within 1e-4. The own bends of a target are those that made it: they are found if they
are 0.01 rad or less from an answer, or from the line through the answers along a curve. Methods:

- `solve`, `solve_all`: `contarm_sim.kinematics.inverse`; `solve` chooses the least total bend.
- SciPy: `scipy.optimize.least_squares`, analytic Jacobian, one random start; what bends exceed their limits by is one
  more residual a section.
- damped: damped least squares (Levenberg, Marquardt) of all targets at once, up to 30 random starts each. Bends run
  free, and those beyond the limits are dropped; or limited, with the same residuals as for SciPy.
- FABRIKc: our reading of Zhang, Yang, Dong, Xu (2018): forward and backward reaching over the corners of the sections'
  tangents, from the straight arm; and again from up to 29 random starts. It knows positions and directions, no roll.

Methods that take long for each target get the first targets alone. `--times` adds processor times of this process a
target; they are left out otherwise, so that the output is the same in each run.
"""

import argparse

import inverse_general as general
import numpy as np
from scipy.optimize import least_squares

from contarm_sim.kinematics import arc, sections
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse import solve, solve_all

COUNT, FEW, STARTS, ITERATIONS, POINTS = 1000, 100, 30, 500, 400
CLOSE, LOOSE, SAME, ROUNDED, LIMITED = 1e-9, 1e-4, 1e-2, 1e-11, 0.3
PROBLEMS = {
    "two sections, position": (2, "position"),
    "three sections, position and direction": (3, "direction"),
    "three sections, pose": (3, "rotation"),
    "four sections, pose": (4, "rotation"),
}


def misses(goals, backbone, bends):
    """Return what tips miss by, as shares of the length, shape (n,); infinite beyond the limits."""
    T = sections.transform(bends, backbone, check=False)
    distance, angle = goals.apart(T[:, :3, 3], T[:, :3, :3])
    within = np.all(np.hypot(bends[..., 0], bends[..., 1]) <= np.array(backbone.limits) + ROUNDED, axis=-1)
    return np.where(within, np.maximum(distance / backbone.length, 0.3 * angle), np.inf)


def by_least_squares(goals, backbone, rng):
    shape, found, evaluations = (1, len(backbone), 2), [], []
    for i in range(len(goals)):
        goal = goals.take([i])

        def residual(x, goal=goal):
            beyond, _ = excess(x, backbone)
            return np.append(goal.terms(x.reshape(shape), backbone)[0][0], LIMITED * beyond)

        def slopes(x, goal=goal):
            _, outward = excess(x, backbone)
            return np.vstack([-goal.terms(x.reshape(shape), backbone)[1][0], LIMITED * outward])

        start = general.random_bends(rng, 1, len(backbone)).ravel()
        done = least_squares(residual, start, slopes, xtol=1e-15, ftol=1e-15, gtol=1e-12, max_nfev=200)
        found.append(done.x.reshape(shape)[0])
        evaluations.append(done.nfev)
    return np.array(found), np.array(evaluations)


def excess(x, backbone):
    """Return what bend angles exceed their limits by, shape (S,), and its slopes by bends, shape (S, 2 S)."""
    bends = x.reshape(-1, 2)
    angles, limits = np.hypot(*bends.T), np.array(backbone.limits)
    outward = np.zeros((len(bends), *bends.shape))
    outward[np.arange(len(bends)), np.arange(len(bends))] = bends * (angles > limits)[:, None] / angles[:, None]
    return np.maximum(angles - limits, 0.0), outward.reshape(len(bends), -1)


def restarted(method, goals, backbone, rng, first=None):
    """Return the best bends of up to `STARTS` starts, random but the first, and how many starts were made."""
    best, least = np.zeros((len(goals), len(backbone), 2)), np.full(len(goals), np.inf)
    starts, left = np.zeros(len(goals), dtype=int), np.arange(len(goals))
    for number in range(STARTS):
        start = general.random_bends(rng, len(left), len(backbone))
        if number == 0 and first is not None:
            start[:] = first
        bends = method(goals.take(left), backbone, start)
        miss = misses(goals.take(left), backbone, bends)
        better = miss < least[left]
        best[left[better]], least[left[better]] = bends[better], miss[better]
        starts[left] += 1
        left = left[least[left] > CLOSE]
        if not len(left):
            break
    return best, starts


def by_free_restarts(goals, backbone, rng):
    return restarted(lambda *given: general.descend(*given, limited=0.0), goals, backbone, rng)


def by_limited_restarts(goals, backbone, rng):
    return restarted(lambda *given: general.descend(*given, limited=LIMITED), goals, backbone, rng)


def by_fabrikc(goals, backbone, rng):
    return fabrikc(goals, backbone, np.zeros((len(goals), len(backbone), 2)))


def by_fabrikc_restarts(goals, backbone, rng):
    return restarted(lambda *given: fabrikc(*given)[0], goals, backbone, rng, first=0.0)


def fabrikc(goals, backbone, bends):
    """Return bends and iterations of forward and backward reaching.

    A section is two equal tangents, of length (L/bend) tan(bend/2), that meet in a corner; from corner to corner the
    arm is a chain of straight links, whose lengths follow from the bend angles at their ends.
    """
    lengths, limits = np.array(backbone.lengths), np.array(backbone.limits)
    tangents = tangent(lengths, np.hypot(bends[..., 0], bends[..., 1]))
    ends = sections.frames(bends, backbone)
    corners = ends[:, :-1, :3, 3] + tangents[..., None] * ends[:, :-1, :3, 2]
    axes = np.array(ends[:, 1:, :3, 2])
    iterations, left = np.full(len(goals), ITERATIONS), np.arange(len(goals))
    base, up = np.zeros(3), np.eye(3)[2]
    for number in range(1, ITERATIONS + 1):
        tip = goals.position[left]
        inwards = unit(corners[:, -1] - tip) if goals.direction is None else -goals.direction[left]
        laid = reach(tip, inwards, corners[:, ::-1], base, tangents[:, ::-1], lengths[::-1], limits[::-1])
        corners, tangents = laid[0][:, ::-1], laid[1][:, ::-1]
        corners, tangents, ways, end = reach(base, up, corners, tip, tangents, lengths, limits)
        miss = np.linalg.norm(end - tip, axis=-1) / backbone.length
        if goals.direction is not None:
            miss = np.maximum(miss, 0.3 * np.linalg.norm(ways[:, -1] - goals.direction[left], axis=-1))
        axes[left] = ways
        done = miss <= 0.5 * CLOSE
        iterations[left[done]] = number
        left, corners, tangents = left[~done], corners[~done], tangents[~done]
        if not len(left):
            break
    return bends_from_axes(axes), iterations


def reach(start, direction, corners, goal, tangents, lengths, limits):
    """Return corners, tangent lengths, the directions beyond the corners, and the end of a chain laid from a start."""
    new, ways, tangents = np.empty_like(corners), np.empty_like(corners), tangents.copy()
    size = corners.shape[1]
    for k in range(size):
        corner = start + tangents[:, k, None] * direction
        way = unit((corners[:, k + 1] if k + 1 < size else goal) - corner)
        cosine = (way * direction).sum(axis=-1)
        across = way - cosine[:, None] * direction
        sine = np.linalg.norm(across, axis=-1)
        angle = np.minimum(np.arctan2(sine, cosine), limits[k])
        across /= np.maximum(sine, 1e-300)[:, None]
        way = np.cos(angle)[:, None] * direction + np.sin(angle)[:, None] * across
        tangents[:, k] = tangent(lengths[k], angle)
        new[:, k], ways[:, k] = start + tangents[:, k, None] * direction, way
        start, direction = new[:, k] + tangents[:, k, None] * way, way
    return new, tangents, ways, start


def tangent(length, angle):
    return length / 2 * np.where(angle < 1e-8, 1.0, np.tan(angle / 2) / np.maximum(angle / 2, 1e-8))


def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def bends_from_axes(axes):
    """Return bends of the sections, shape (n, S, 2), of the directions of their ends, shape (n, S, 3)."""
    frame, bends = np.eye(3), []
    for k in range(axes.shape[1]):
        x, y, z = np.moveaxis((np.swapaxes(frame, -1, -2) @ axes[:, k, :, None])[..., 0], -1, 0)
        lateral = np.hypot(x, y)
        scale = np.arctan2(lateral, z) / np.maximum(lateral, 1e-300)
        bends.append(np.stack([scale * x, scale * y], axis=-1))
        frame = frame @ arc.rotation(bends[-1])
    return np.stack(bends, axis=1)


def distance(curve, own):
    """Return how far bends are from a curve of bends, straight from point to point [rad]."""
    points, own = curve.reshape(len(curve), -1), own.ravel()
    if len(points) == 1:
        return np.linalg.norm(points[0] - own)
    steps, offsets = points[1:] - points[:-1], own - points[:-1]
    along = np.clip((steps * offsets).sum(axis=-1) / np.maximum((steps**2).sum(axis=-1), 1e-300), 0, 1)
    return np.linalg.norm(offsets - along[:, None] * steps, axis=-1).min()


def by_solve(asked, backbone, rng):
    return solve(**asked, backbone=backbone).bends, None


def all_of_them(asked, backbone, rng):
    """Return lists of curves of bends, one list a target."""
    each = [dict(zip(asked, values, strict=True)) for values in zip(*asked.values(), strict=True)]
    return [solve_all(**one, backbone=backbone, points=POINTS) for one in each], None


def of_goals(method):
    return lambda asked, backbone, rng: method(general.Goals(**asked), backbone, rng)


METHODS = {
    "`solve`": (by_solve, "", COUNT),
    "`solve_all`": (all_of_them, "", FEW),
    "SciPy, one start": (of_goals(by_least_squares), "evaluations", FEW),
    f"damped, free, up to {STARTS} starts": (of_goals(by_free_restarts), "starts", COUNT),
    f"damped, limited, up to {STARTS} starts": (of_goals(by_limited_restarts), "starts", COUNT),
    "FABRIKc, straight start": (of_goals(by_fabrikc), "iterations", COUNT),
    f"FABRIKc, up to {STARTS} starts": (of_goals(by_fabrikc_restarts), "starts", COUNT),
}
FEWER = {"three sections, position and direction": 20}


def judged(asked, backbone, answers, effort, effort_in, own):
    """Return the cells of a row: shares solved, median effort of what is solved, answers, share of own bends found."""
    curves = [[bends[None]] for bends in answers] if isinstance(answers, np.ndarray) else answers
    sizes = [sum(map(len, found)) for found in curves]
    of = np.repeat(np.arange(len(curves)), sizes)
    every = np.concatenate([curve for found in curves for curve in found])
    miss = np.full(len(curves), -np.inf)
    np.maximum.at(miss, of, misses(general.Goals(**asked).take(of), backbone, every))
    miss[np.array(sizes) == 0] = np.inf
    near = [any(distance(curve, bends) <= SAME for curve in found) for found, bends in zip(curves, own, strict=False)]
    shares = [f"{100 * np.mean(miss <= most):.1f} %" for most in (CLOSE, LOOSE)]
    middle = "-" if effort is None else f"{np.median(effort[miss <= CLOSE]):.0f} {effort_in}"
    middle = middle.removesuffix("s") if middle.startswith("1 ") else middle
    free = own[0].size - general.Goals(**asked).conditions
    found = (f"{np.mean(sizes):.2f}", "curves", f"{np.mean(sizes):.0f} samples")[min(free, 2)]
    return [*shares, middle, "1" if isinstance(answers, np.ndarray) else found, f"{100 * np.mean(near):.0f} %"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", action="store_true", help="add processor times a target")
    times = parser.parse_args().times
    heads = ["problem", "method", "targets", "to 1e-9", "to 1e-4", "median effort", "answers a target"]
    heads += ["own bends found"] + ["us a target"] * times
    print("| " + " | ".join(heads) + " |\n" + "|---" * len(heads) + "|", flush=True)
    for number, (name, (size, what)) in enumerate(PROBLEMS.items()):
        backbone = Backbone(lengths=general.LENGTHS[:size])
        own = general.random_bends(np.random.default_rng(number), COUNT, size)
        asked = general.targets(own, backbone, what)
        for method, (function, effort_in, count) in METHODS.items():
            if what == "rotation" and "FABRIKc" in method:
                continue
            if function is all_of_them and name in FEWER:
                count = FEWER[name]
            some = {key: value[:count] for key, value in asked.items()}
            rng = np.random.default_rng(100 + number)
            (answers, effort), seconds = general.timed(lambda f=function, s=some, b=backbone, r=rng: f(s, b, r))
            cells = [name, method, count, *judged(some, backbone, answers, effort, effort_in, own)]
            cells += [f"{1e6 * seconds / count:.0f}"] * times
            print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    main()

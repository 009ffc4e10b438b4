"""Cost of the kinematics over the bare NumPy calls that they stand for, on the same number of poses.

The floor of each is what its textbook formula needs at least: hypot or the root of a sum of squares, arctan2, sine,
cosine and a division, on contiguous columns that stay in the cache, with no checks, no miss and no results stored.
For `nearest` that is one step of an iteration from a good start: three arctan2, a sine, a cosine, two roots and a
division. A ratio below 1 is possible because sine and cosine are sums of series here.

Run to run the medians vary by some 10 % on an idle machine and by half where others work; `transform` the most, because
what it writes, 128 bytes a pose, comes from the system page by page.
"""

import time

import numpy as np

from contarm_sim.kinematics import arc, dome

LENGTH, COUNT, BLOCK, REPEATS = 0.37, 300_000, 8192, 9


def bare_pose(x, y):
    half = 0.5 * np.sqrt(x * x + y * y)
    np.sin(half) / half
    np.cos(half)


def bare_inverse(x, y, z):
    half = np.arctan2(np.hypot(x, y), z)
    np.sin(half) / half


def bare_nearest(x, y, z):
    rho = np.sqrt(x * x + y * y)
    for _ in range(3):
        half = np.arctan2(rho, z)
    sine, cosine = np.sin(half), np.cos(half)
    np.sqrt(sine * sine + cosine * cosine)
    half / rho


def cases():
    """Yield name, what to time, its floor, and the columns that the floor works on."""
    rng = np.random.default_rng(0)
    bend = arc.from_polar(rng.uniform(0.01, 3.1, COUNT), rng.uniform(-np.pi, np.pi, COUNT))
    tips = arc.position(bend, LENGTH)
    yield "arc.position", lambda: arc.position(bend, LENGTH), bare_pose, bend
    yield "arc.rotation", lambda: arc.rotation(bend), bare_pose, bend
    yield "arc.transform", lambda: arc.transform(bend, LENGTH), bare_pose, bend
    yield "arc.jacobian", lambda: arc.jacobian(bend, LENGTH), bare_pose, bend
    yield "bend_from_tip, refuse", lambda: dome.bend_from_tip(tips, LENGTH), bare_inverse, tips
    scale = rng.uniform(0, 1, (COUNT, 1))
    targets = {
        "on the dome": tips,
        "20 % about it": tips * (0.8 + 0.4 * scale),
        "in a box of 3 lengths": rng.uniform(-1.5 * LENGTH, 1.5 * LENGTH, (COUNT, 3)),
        "inside the dome": tips * np.cbrt(scale),
    }
    for where, these in targets.items():
        yield f"nearest, {where}", lambda t=these: dome.bend_from_tip(t, LENGTH, "nearest"), bare_nearest, these


def seconds(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


def in_blocks(bare, columns):
    for start in range(0, COUNT, BLOCK):
        bare(*(column[start : start + BLOCK] for column in columns))


def main():
    print(f"{COUNT} poses, medians of {REPEATS} (lowest to highest)   [ns a pose]   [ratio to bare calls]")
    for name, function, bare, columns in cases():
        columns = list(columns.T.copy())
        times = np.array([[seconds(in_blocks, bare, columns), seconds(function)] for _ in range(REPEATS)])
        ratio = np.quantile(times[:, 1] / times[:, 0], [0.5, 0, 1])
        each = 1e9 * times.min(axis=0) / COUNT
        print(f"{name:32} {each[1]:7.1f} over {each[0]:5.1f}   {ratio[0]:6.2f}  ({ratio[1]:.2f} to {ratio[2]:.2f})")
    bend, tip = np.array([0.9, 0.4]), arc.position([0.9, 0.4], LENGTH)
    for name, function in {
        "one arc.position": lambda: arc.position(bend, LENGTH),
        "one arc.position, check=False": lambda: arc.position(bend, LENGTH, check=False),
        "one bend_from_tip": lambda: dome.bend_from_tip(tip, LENGTH),
    }.items():
        best = min(seconds(lambda f=function: [f() for _ in range(200)]) for _ in range(REPEATS)) / 200
        print(f"{name:32} {1e6 * best:7.1f} us")


if __name__ == "__main__":
    main()

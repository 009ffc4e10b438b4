"""Cost of the inverse kinematics of 10^6 targets over the bare NumPy calls that it cannot do without."""

import time

import numpy as np

from contarm_sim.kinematics import arc, dome

LENGTH, COUNT, REPEATS = 0.37, 1_000_000, 9


def bare(x, y, z):
    rho = np.hypot(x, y)
    half = np.arctan2(rho, z)
    return np.sin(half) / half


def main():
    rng = np.random.default_rng(0)
    bend = arc.from_polar(rng.uniform(0.01, 3.1, COUNT), rng.uniform(-np.pi, np.pi, COUNT))
    targets = arc.position(bend, LENGTH)
    columns = [targets[:, i] for i in range(3)]
    times = {"bare": [], "bend_from_tip": []}
    for _ in range(REPEATS):
        start = time.perf_counter()
        bare(*columns)
        middle = time.perf_counter()
        dome.bend_from_tip(targets, LENGTH)
        times["bare"].append(middle - start)
        times["bend_from_tip"].append(time.perf_counter() - middle)
    ratios = np.divide(times["bend_from_tip"], times["bare"])
    print(f"bare hypot, arctan2, sinc-like  {1e3 * min(times['bare']):8.1f} ms")
    print(f"bend_from_tip, with miss        {1e3 * min(times['bend_from_tip']):8.1f} ms")
    low, middle, high = np.quantile(ratios, [0, 0.5, 1])
    print(f"ratio                           {middle:8.2f}  (median of {REPEATS}, {low:.2f} to {high:.2f})")


if __name__ == "__main__":
    main()

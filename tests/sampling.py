"""Bends that always include the singular cases: straight, near straight, near pi, both singular planes."""

import numpy as np

from contarm_sim.kinematics import arc


def bends(count: int, seed: int = 0, largest: float = np.pi) -> np.ndarray:
    rng = np.random.default_rng(seed)
    third = count // 10
    angle = np.concatenate(
        [
            rng.uniform(0, largest, count - 2 * third),
            10.0 ** rng.uniform(-12, -1, third),
            np.nextafter(largest, 0) - 10.0 ** rng.uniform(-9, -1, third),
        ]
    )
    angle[:4] = 0.0, 1e-12, 1e-9, np.nextafter(largest, 0) - 1e-9
    plane = rng.uniform(-np.pi, np.pi, count)
    plane[::7] = 0.0
    plane[1::7] = np.pi / 2
    plane[2::7] = np.pi
    return arc.from_polar(angle, plane)

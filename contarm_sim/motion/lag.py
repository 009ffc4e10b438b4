"""What motion adds to an arm's error: the distance from where it is to where it would rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from contarm_sim.control.command import Controller
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.results.samples import Samples


def motion_part(
    arm: Arm, samples: Samples, controller: Controller, poses: int = 100, extrapolated: bool = False
) -> tuple[Array, Array]:
    """Return what motion adds: (times [s], distances [m]), each of shape (K,), K about `poses`.

    Distances are from simulated tips, evenly picked, to where they would rest under the same commanded bend and
    controller: inertia, damping and lag.
    """
    chosen = slice(None, None, max(1, len(samples) // poses))
    given = samples.bend[chosen], samples.target[chosen], controller
    rest = poses_at_rest(arm, *given).stations[:, -1]
    if extrapolated:
        half = arm.links // 2
        coarse = poses_at_rest(replace(arm, links=half), *given).stations[:, -1]
        rest = rest + (rest - coarse) / ((arm.links / half) ** 2 - 1)
    return samples.time[chosen], np.linalg.norm(samples.stations[chosen, -1] - rest, axis=-1)

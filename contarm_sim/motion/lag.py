"""What motion adds to an arm's error: the distance from where it is to where it would rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from contarm_sim.control.base import Controller
from contarm_sim.control.registry import controller as resolved
from contarm_sim.kinematics.arrays import Array
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.results.trajectory import Trajectory


def motion_part(trajectory: Trajectory, poses: int = 100, controller: Controller | None = None) -> tuple[Array, Array]:
    """Return what motion adds: (times [s], distances [m]), each of shape (K,), K about `poses`.

    Distances are from simulated tips, evenly picked, to where they would rest under the same commanded bend and
    controller: inertia, damping and lag.

    Args:
        controller: what drove the arm; default the one of the trajectory's name.

    Raises:
        EquilibriumError: a commanded pose has no rest.
    """
    arm, chosen = trajectory.arm, slice(None, None, max(1, len(trajectory) // poses))
    bend, target = trajectory.bend[chosen], trajectory.target[chosen]
    reference = Reference(np.zeros(len(bend)), target, bend, arm.length)
    driven = controller or resolved(trajectory.controller)
    rest = poses_at_rest(arm, reference, driven).tip
    if trajectory.extrapolated:
        half = arm.links // 2
        coarse = poses_at_rest(replace(arm, links=half), reference, driven).tip
        rest = rest + (rest - coarse) / ((arm.links / half) ** 2 - 1)
    return trajectory.time[chosen], np.linalg.norm(trajectory.tip[chosen] - rest, axis=-1)

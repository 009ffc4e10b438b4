"""What motion adds to an arm's error: the distance from where it is to where it would rest."""

from __future__ import annotations

import numpy as np

from contarm_sim.control.base import Controller
from contarm_sim.control.registry import controller as resolved
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.chain import richardson
from contarm_sim.motion.motion_extrapolation import coarser
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference, section_lengths
from contarm_sim.results.trajectory import Trajectory


def moved_by_motion(
    trajectory: Trajectory, poses: int = 100, controller: Controller | None = None
) -> tuple[Array, Array]:
    """Return what motion adds: (times [s], shape (K,); displacements [m], shape (K, 3)), K from `poses` to twice that.

    Displacements are of simulated tips, evenly picked, from where they would rest under the same commanded bend and
    controller: inertia, damping and lag.

    Args:
        controller: what drove the arm; default the one of the trajectory's name.

    Raises:
        EquilibriumError: a commanded pose has no rest.
    """
    arm, chosen = trajectory.arm, slice(None, None, max(1, len(trajectory) // poses))
    bend, target = trajectory.bend[chosen], trajectory.target[chosen]
    reference = Reference(np.zeros(len(bend)), target, bend, section_lengths(arm))
    driven = controller or resolved(trajectory.controller)
    if driven.actuation != trajectory.actuation:
        given = f"{driven.name!r}, which drives {driven.actuation}"
        raise InputError("controller", given, f"the one that drove the {trajectory.actuation} of this trajectory")
    rest = poses_at_rest(arm, reference, driven).tip
    if trajectory.extrapolated:
        half = coarser(arm)
        coarse = poses_at_rest(half, reference, driven).tip
        rest = rest + richardson(arm.links, half.links) * (rest - coarse)
    return trajectory.time[chosen], trajectory.tip[chosen] - rest

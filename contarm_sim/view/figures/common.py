"""What several figures start from: the spiral, followed once."""

from __future__ import annotations

from functools import lru_cache

from contarm_sim import paths
from contarm_sim.kinematics import dome
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.results.trajectory import Trajectory

DURATION = 10.0


@lru_cache(maxsize=4)
def followed(arm: Arm, name: str = "spiral", project: dome.Projection = "refuse") -> Trajectory:
    """Return the motion of an arm that follows a path in ten seconds with the `servo` controller."""
    path = paths.named(name, arm.length, DURATION)
    return simulate(arm, Reference.from_path(path, arm, project=project))

"""What several figures start from: the spiral, followed once."""

from __future__ import annotations

from functools import lru_cache

from contarm_sim import paths
from contarm_sim.kinematics import dome
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import CONTROL_RATE, simulate
from contarm_sim.results.samples import Samples

DURATION = 10.0


@lru_cache(maxsize=4)
def followed(arm: Arm, name: str = "spiral", project: dome.Projection = "refuse") -> Samples:
    """Return the samples of an arm that follows a path in ten seconds with the `servo` controller."""
    _, targets = paths.named(name, arm.length, DURATION).targets(CONTROL_RATE)
    bend = dome.bend_from_tip(targets, arm.length, project).bend
    return simulate(arm, targets, bend).samples

"""What several figures start from: motions, each simulated once; colours of bends; how an arm stands, in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contarm_sim import paths
from contarm_sim.kinematics import dome
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.colours import ANALYTIC, SIMULATED
from contarm_sim.view.once import once

DURATION = 10.0

BROAD: dict[str, Any] = {"color": SIMULATED, "linewidth": 3.2, "label": "simulated"}
THIN: dict[str, Any] = {"color": ANALYTIC, "linewidth": 1.3, "linestyle": (0, (3.5, 1.8)), "label": "analytic"}
"""A broad bright line with a thin dark one on it: both stay visible where they agree."""

_BEND_MAP, _BEND_END = "viridis", 0.86
"""The end of the map is too bright for lines on white."""


@dataclass(frozen=True, eq=False)
class OwnPath:
    """What the arm follows in the figures of one's own path.

    Attributes:
        name: of the path in headings: the circle.
        reference: the motion along it.
    """

    name: str
    reference: Reference


@once
def followed(arm: Arm, own: OwnPath | None = None, project: dome.Projection = "refuse") -> Trajectory:
    """Return the motion of an arm with the `servo` controller: the paper's spiral in ten seconds, or one's own path.

    Args:
        project: what becomes of the targets of the paper's spiral; unless targets must be reached, those on its shell.
    """
    if own is not None:
        return simulate(arm, own.reference)
    name = "spiral" if project == "refuse" else "sphere-spiral"
    path = paths.named(name, arm.length, DURATION)
    return simulate(arm, Reference.from_path(path, arm, project=project))


def called(own: OwnPath | None) -> str:
    """Return what a path is called in a heading."""
    return "the spiral" if own is None else own.name


def bend_colours(angles: ArrayLike) -> Any:
    """Return colours, shape (K, 4), of bend angles [deg]: dark for small ones, bright for half a turn."""
    from matplotlib import colormaps

    return colormaps[_BEND_MAP](_BEND_END * np.asarray(angles) / 180)

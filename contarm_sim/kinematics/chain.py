"""The uniformly bent chain of rigid links with ball joints, in closed form.

N joints at pitch h = length/N with a half link at each end, every joint bent by
beta = |bend|/N in one plane. Then every station s = i h (base, disks, tip) lies on the arc of
the same bend whose length is length * (beta/2)/tan(beta/2). `hinges` has the chain of hinge pairs.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array, as_vectors, sinc


def _half_joint_angle(bend: Array, links: int) -> Array:
    return np.hypot(bend[..., 0], bend[..., 1]) / (2 * links)


def effective_length(bend: Any, length: float, links: int) -> Array:
    """Return the length [m], shape (...), of the arc through the chain's stations."""
    half = _half_joint_angle(as_vectors(bend, 2, "bend"), links)
    return length * np.cos(half) / sinc(half)


def station(bend: Any, length: float, links: int, index: Any) -> Array:
    """Return positions [m], shape (..., 3), of stations 0 (base), 1 .. links - 1 (disks), links (tip).

    `index` broadcasts against the leading axes of `bend`.
    """
    bend = as_vectors(bend, 2, "bend")
    scale = effective_length(bend, length, links) / length
    return scale[..., None] * arc.position(bend, length, np.asarray(index) / links)


def tip(bend: Any, length: float, links: int) -> Array:
    """Return tip positions [m], shape (..., 3). The tip's orientation is that of the arc."""
    return station(bend, length, links, links)


def discretisation_error(bend: Any, length: float, links: int) -> Array:
    """Return the distance [m], shape (...), between the arc's tip and the chain's: known without a simulation.

    Relative to the tip's distance from the base it is 1 - (beta/2)/tan(beta/2) ~ bend_angle^2/(12 links^2).
    """
    bend = as_vectors(bend, 2, "bend")
    return np.linalg.norm(arc.position(bend, length) - tip(bend, length, links), axis=-1)


def richardson(links: int, fewer: int) -> float:
    """Return what share of (x_N - x_n) is added to x_N by Richardson's extrapolation, N = `links`, n = `fewer`.

    The chain's error is of second order in 1/N: 1/((N/n)^2 - 1).
    """
    return 1 / ((links / fewer) ** 2 - 1)

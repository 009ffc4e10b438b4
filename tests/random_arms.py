"""Seeded arms within the physically sane set, and whether one can stand at a bend, without the package's solvers.

Sane is what a workshop could build: 2 to 60 links, 0.1 to 1.5 m, a radius of 3 to 60 mm below length/pi, 10 g to 5 kg,
EI from 1e-3 to 10 N m^2. Many of these arms are too soft for their weight, or too stiff for their muscles: `can_stand`
tells those that can stand.
"""

from dataclasses import replace

import numpy as np
from rod import ANGLES, NoEquilibriumError, parallel_rod

from contarm_sim.model.arm import Arm
from contarm_sim.model.mckibben import McKibben

MARGIN = 0.1
"""Least eigenvalue of an arm that can stand, as a share of the least stiffness, EI or GJ: further from buckling."""

FORCE_SHARE = 0.95
"""Of the blocked force, what the strongest muscle of an arm that can stand needs at most."""


def _between(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def random_arm(rng, twist=0.0, spans=0.0) -> Arm:
    """Return an arm of random size, weight, stiffness and gravity; the same for the same state of `rng`.

    Args:
        twist, spans: shares of the arms that twist, and whose muscles run in straight spans.
    """
    length = _between(rng, 0.1, 1.5)
    mass = _between(rng, 0.01, 5.0)
    stiffness = _between(rng, 1e-3, 10.0)
    towards = rng.normal(size=3)
    gravity = 9.81 * towards / np.linalg.norm(towards) * (rng.random() < 0.85)
    return Arm(
        length=length,
        links=int(rng.integers(2, 61)),
        mass=mass,
        bending_stiffness=stiffness,
        muscle_radius=_between(rng, 0.003, min(0.06, 0.95 * length / np.pi)),
        gravity=tuple(gravity),
        payload=mass * _between(rng, 0.05, 2.0) * (rng.random() < 0.5),
        joint_friction=1e-3 * stiffness / length if rng.random() < 0.2 else None,
        torsional_stiffness=stiffness * _between(rng, 0.3, 3.0) if rng.random() < twist else None,
        muscle=McKibben(
            braid_friction=_between(rng, 0.01, 1.0) if rng.random() < 0.2 else None,
        ),
        path="spans" if rng.random() < spans else "parallel",
    )


def can_stand(arm, bend) -> bool:
    """Whether the ideal rod, its muscle lengths held at a bend [rad], shape (2,), is stable and muscles can hold it.

    Weight and lengths are raised together from none; no muscle needs more than a share of its blocked force while the
    slackest pulls with the least tension, and none is asked for a length that it cannot take. True is sure for many
    links; False only says that this path is barred.
    """
    directions = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
    lengths = arm.length - arm.muscle_radius * directions @ np.asarray(bend, dtype=float)
    shortest, longest = arm.muscle_length_range
    if lengths.min() < shortest or lengths.max() > longest:
        return False
    try:
        rod = parallel_rod(replace(arm, path="parallel"), lengths=lengths)
    except NoEquilibriumError:
        return False
    needed = np.ptp(rod.tensions) + arm.muscle.min_tension
    least = min(arm.bending_stiffness, arm.torsional_stiffness or np.inf)
    return bool(rod.margin > MARGIN * least and needed < FORCE_SHARE * arm.muscle.blocked_force)

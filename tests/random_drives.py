"""Seeded load cases of a driven arm, with the ideal rod's answer: what a simulation of it is measured on."""

from dataclasses import dataclass
from itertools import islice

import numpy as np
from rod import ANGLES, NoEquilibriumError, Rod, parallel_rod, spans_rod

from contarm_sim.model.arm import Arm

MARGIN = 0.2
"""Least eigenvalue of a kept case, as a share of the least stiffness, EI or GJ: nearer to a fold small errors grow."""

LARGEST_BEND = np.radians(150)
"""Largest integral of curvature of a kept case [rad]."""


@dataclass(frozen=True)
class Case:
    """An arm with its gravity and payload, a drive (tensions [N], pressures [Pa]), a dead force and couple at the tip.

    Attributes:
        rod: its equilibrium with sheathed muscles.
    """

    arm: Arm
    kind: str
    values: np.ndarray
    force: np.ndarray
    moment: np.ndarray
    rod: Rod

    def spans(self, disks=None, **options):
        """Return the equilibrium with straight spans between disks (default: as many as links)."""
        drive = {self.kind: self.values}
        return spans_rod(self.arm, disks, force=self.force, moment=self.moment, **drive, **options)


def random_cases(seed, count, kind="tensions", twist=False):
    """Return `count` cases of the default arm, with a torsional stiffness if `twist`; more of them begin with these."""
    return list(islice(_kept(np.random.default_rng(seed), kind, twist), count))


def _direction(rng):
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def _kept(rng, kind, twist):
    """Yield the random cases that a stable rod reaches, every load raised in proportion from none."""
    while True:
        stiffness = float(np.exp(rng.uniform(np.log(0.03), np.log(0.2))))
        gravity = 9.81 * _direction(rng) * (rng.random() < 0.7)
        payload = rng.uniform(0, 0.1) * (rng.random() < 0.5)
        force = rng.normal(0, 0.3) * _direction(rng) * (rng.random() < 0.7)
        moment = rng.normal(0, 0.05) * _direction(rng) * (rng.random() < 0.5)
        values = rng.uniform(5, 40, 3) if kind == "tensions" else rng.uniform(90e3, 700e3, 3)
        arm = Arm(gravity=tuple(gravity), payload=payload, torsional_stiffness=stiffness if twist else None)
        try:
            rod = parallel_rod(arm, force=force, moment=moment, **{kind: values})
        except NoEquilibriumError:
            continue
        least = min(arm.bending_stiffness, arm.torsional_stiffness or np.inf)
        if rod.margin > MARGIN * least and _usable(rod, arm):
            yield Case(arm, kind, values, force, moment, rod)


def _usable(rod, arm):
    """Whether the rod bends less than LARGEST_BEND, and each muscle keeps within what its braid allows."""
    shortest, longest = arm.muscle_length_range
    bend = rod.grid.weights @ np.linalg.norm(rod.curvature[:, :2], axis=1)
    inside = 1 + arm.muscle_radius * rod.curvature[:, :2] @ np.stack([np.sin(ANGLES), -np.cos(ANGLES)])
    return bend < LARGEST_BEND and inside.min() > 0 and shortest < rod.lengths.min() and rod.lengths.max() < longest

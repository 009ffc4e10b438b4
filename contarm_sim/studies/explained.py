"""What the ideal rod explains: Newton's law along the backbone, from the recorded motion and no engine.

The rod of `mechanics.rod` gets the muscle lengths, tensions, accelerations and joint rates that were recorded, and the
arm's weight; its tip is where sag, inertia and damping put it. What is left of the shape term is not explained.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics import hinges
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles, shape
from contarm_sim.mechanics.rod import MODES, SEGMENTS, STATIONS, polynomials, rod_tips
from contarm_sim.model.arm import Arm
from contarm_sim.model.section import Section
from contarm_sim.results.compare import Comparison
from contarm_sim.results.summary import Spread, known_spread
from contarm_sim.results.trajectory import Trajectory


@dataclass(frozen=True)
class RodParts:
    """What the ideal rod says of the shape term.

    Attributes:
        sag: how far gravity and payload move the rod's tip; None without gravity.
        inertia: how far inertia and damping move it further.
        unexplained: what is left. Each is None where no rod rests.
    """

    sag: Spread | None
    inertia: Spread | None
    unexplained: Spread | None


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class Explanation:
    """The shape term at K samples, evenly picked, beside the ideal rod; distances [m], NaN where no rod rests.

    Attributes:
        index: of the samples, shape (K,).
        sag: how far gravity and payload move the rod's tip at rest off the arc, shape (K,).
        inertia: how far inertia and damping move it further, shape (K,); zero at rest.
        remainder: what is left of the shape term, shape (K,). The three vectors add up to it.
    """

    index: NDArray[np.intp]
    sag: Array
    inertia: Array
    remainder: Array

    def summary(self, arm: Arm) -> RodParts:
        """Return the parts in m and percent of length."""
        sag = known_spread(self.sag, arm.length) if any(arm.gravity) else None
        inertia, left = (known_spread(each, arm.length) for each in (self.inertia, self.remainder))
        return RodParts(sag, inertia, left)


def explain(samples: Trajectory, comparison: Comparison, poses: int = 100) -> Explanation:
    """Return what the rod explains of the shape at about `poses` samples; all of them at rest.

    In motion first and last sample have no acceleration and are left out; fewer than three samples have none at all.
    """
    arm, moving = samples.arm, bool(len(samples) > 1 and samples.time[-1] > samples.time[0])
    last = len(samples) - 1
    picked = np.arange(1, last, max(1, len(samples) // poses)) if moving else np.arange(len(samples))
    bend = comparison.measured_bend[picked]
    arcs = shape.position(bend, arm)
    weight = np.broadcast_to(np.array(arm.gravity), (len(picked), 3))
    guess = _coefficients(arm, samples.qpos[picked])
    tension = np.stack([samples.muscle_tensions[picked, own].sum(axis=-1) for own in muscles.slices(arm)], axis=-1)
    resting = [np.repeat(_density(section) * weight[:, None], SEGMENTS, axis=1) for section in arm.sections]
    at_rest = rod_tips(arm, bend, np.concatenate(resting, axis=1), arm.payload * weight, 0.0, tension, guess)
    moved = at_rest
    if moving:
        period = float(samples.time[1] - samples.time[0])
        before, after = picked - 1, picked + 1
        swing = (samples.stations[after] - 2 * samples.stations[picked] + samples.stations[before]) / period**2
        rates = (samples.qpos[after] - samples.qpos[before]) / (2 * period)
        parts = zip(arm.sections, resting, _by_section(arm, swing), strict=True)
        load = [rest - _density(section) * _between(own) for section, rest, own in parts]
        moved = rod_tips(
            arm, bend, np.concatenate(load, axis=1), arm.payload * (weight - swing[:, -1]),
            _damping(arm, rates), tension, guess,
        )  # fmt: skip
    left = (comparison.simulated_tip - comparison.followed_tip)[picked]
    return Explanation(
        index=picked,
        sag=np.linalg.norm(at_rest - arcs, axis=-1),
        inertia=np.linalg.norm(moved - at_rest, axis=-1),
        remainder=np.linalg.norm(left - (moved - arcs), axis=-1),
    )


def _density(section: Section) -> float:
    """Return a section's mass by its length [kg/m]."""
    return section.mass / section.length


def _by_section(arm: Arm, values: Array) -> list[Array]:
    """Return values at an arm's stations, shape (K, N + 1, 3), section by section, their ends included."""
    ends = np.cumsum([0, *(section.links for section in arm.sections)])
    return [values[:, first : last + 1] for first, last in pairwise(ends)]


def _between(values: Array) -> Array:
    """Return values at a section's N + 1 even stations, shape (K, N + 1, 3), at the rod's `STATIONS`, (K, S, 3)."""
    place = STATIONS * (values.shape[1] - 1)
    low = np.floor(place).astype(int)
    share = (place - low)[:, None]
    return np.asarray((1 - share) * values[:, low] + share * values[:, low + 1])


def _by_axis(arm: Arm, angles: Array) -> list[Array]:
    """Return hinge angles, shape (K, dofs), section by section, by joint and axis, (K, N, 3), twist 0 where none is."""
    out, first = [], 0
    for section in arm.sections:
        each = 2 if section.torsional_stiffness is None else 3
        found = np.zeros((len(angles), section.links, 3))
        for i in range(section.links):
            for j, axis in enumerate(hinges.AXES[each][i % 4]):
                found[:, i, "xyz".index(axis)] = angles[:, first + each * i + j]
        out.append(found)
        first += each * section.links
    return out


def _integrals(arm: Arm, angles: Array) -> Array:
    """Return sums over each section's joints of their angles times the polynomials, shape (K, S, 1 + MODES, 3)."""
    parts = zip(arm.sections, _by_axis(arm, angles), strict=True)
    found = [
        np.einsum("nk,tnd->tkd", polynomials((np.arange(section.links) + 0.5) / section.links), own)
        for section, own in parts
    ]
    return np.stack(found, axis=1)


def _coefficients(arm: Arm, qpos: Array) -> Array:
    """Return the curvature's Legendre coefficients [rad] that joint angles amount to, shape (K, S, 1 + MODES, 3)."""
    return (2 * np.arange(1 + MODES)[:, None] + 1) * _integrals(arm, qpos)


def _damping(arm: Arm, rates: Array) -> Array:
    """Return the joints' damping moments integrated with the polynomials [N m^2], shape (K, S, 1 + MODES, 3)."""
    resisted = [
        section.damping_time
        * np.array([section.bending_stiffness, section.bending_stiffness, section.torsional_stiffness or 0.0])
        for section in arm.sections
    ]
    return np.asarray(np.array(resisted)[:, None] * _integrals(arm, rates))

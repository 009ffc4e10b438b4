"""What muscles of arms of several sections pull with in bends of constant curvature, by virtual work alone.

Nothing of the package's mechanics or engine is used but the closed-form poses and the law: gravity's work is
differenced along the bends, the backbone's is (EI/L) bend, and a muscle along the backbone at radius r works
r T (u . dbend) in every section that it crosses.
"""

import numpy as np

from contarm_sim.kinematics import sections
from contarm_sim.kinematics.backbone import Backbone

POINTS = 16
"""Places at which the mass of the arm is summed."""


def potential(bends, arm):
    """Return the energy of weight [J] at bends [rad], shape (..., S, 2)."""
    backbone = Backbone(lengths=tuple(section.length for section in arm.sections))
    ends, total = np.cumsum([0.0, *backbone.lengths]), 0.0
    for number, section in enumerate(arm.sections):
        for share in (np.arange(POINTS) + 0.5) / POINTS:
            xi = (ends[number] + share * section.length) / backbone.length
            place = sections.position(bends, backbone, xi)
            total = total - section.mass / POINTS * place @ np.array(arm.gravity)
    return total - arm.payload * sections.position(bends, backbone) @ np.array(arm.gravity)


def moments(bends, arm, step=1e-5):
    """Return the generalised moments [N m] that muscles must give, shape (..., S, 2)."""
    stiffness = np.array([section.bending_stiffness / section.length for section in arm.sections])
    found = stiffness[:, None] * bends
    for index in np.ndindex(bends.shape[-2:]):
        change = np.zeros(bends.shape[-2:])
        change[index] = step
        found[(..., *index)] += (potential(bends + change, arm) - potential(bends - change, arm)) / (2 * step)
    return found


def tensions(bends, arm):
    """Return tensions [N] and lengths [m], shape (..., M), that hold bends; the slackest of a group at its least."""
    needed, pulls, lengths = moments(bends, arm), [], []
    for group in reversed(arm.groups):
        u = np.stack([np.cos(group.routing.angles), np.sin(group.routing.angles)], axis=-1)
        own = needed[..., group.section, :].copy()
        pull = 2 / (group.routing.count * group.routing.radius) * own @ u.T
        pull += group.law.min_tension - pull.min(axis=-1, keepdims=True)
        pulls.insert(0, pull)
        crossed = [number for number in range(len(arm.sections)) if group.crosses(number)]
        lengths.insert(0, group.length - group.routing.radius * bends[..., crossed, :].sum(axis=-2) @ u.T)
        for number in crossed:
            needed[..., number, :] -= own
    return np.concatenate(pulls, axis=-1), np.concatenate(lengths, axis=-1)


def random_bends(rng, count, arm, largest=np.pi / 2):
    """Return bends of sections [rad], shape (count, S, 2), as often near the largest angle as below."""
    shape = (count, len(arm.sections))
    angle, plane = largest * rng.uniform(0, 1, shape) ** 0.3, rng.uniform(-np.pi, np.pi, shape)
    return angle[..., None] * np.stack([np.cos(plane), np.sin(plane)], axis=-1)


def inflated_pressures(bends, arm):
    """Return pressures [Pa], shape (..., M), that hold bends with all muscles inflated, one of a group at the lowest.

    For pneumatic muscles that each run through their own section alone, parallel to the backbone.
    """
    pulls, lengths = tensions(bends, arm)
    found, first = [], 0
    for group in arm.groups:
        own = slice(first, first + group.routing.count)
        first += group.routing.count
        law, rest = group.law, group.rest_length
        per_pascal = law.force(1.0, lengths[..., own], rest)
        lacking = law.min_pressure * per_pascal - pulls[..., own]
        found.append((pulls[..., own] + np.maximum(lacking.max(axis=-1, keepdims=True), 0)) / per_pascal)
    return np.concatenate(found, axis=-1)

"""A map of solutions along a path of targets: samples at way points, and the shortest way through them.

Way points lie on the path at about equal distances. At each, random starts lead to samples of the solutions; the
samples of the neighbours, carried over, join them, so that branches that are narrow or isolated are followed. Of all
ways from the first way point to the last, dynamic programming takes the one of least motion and penalty; to jump
between solutions farther apart than `FARTHEST_STEP` is a last resort.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import Choice, penalty
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.general.starts import spread
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import clamped
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.kinematics.inverse.targets import in_closed_form, solve
from contarm_sim.kinematics.inverse.three.solutions import all_poses
from contarm_sim.kinematics.inverse.two.solutions import family_samples

FARTHEST_STEP = 0.8
"""Distance between solutions at neighbouring way points beyond which one is not taken for the other's course [rad]."""

JUMP = 1e6
"""Cost of a jump, beside squares of motions [rad^2]."""

_STEPS = 25  # of a search from a random start: those that take more are left
_CHOICE = 1.0  # cost of a penalty of 1 rad along the whole path, beside the square of its motion [rad^2]


@dataclass
class Layer:
    """Samples at one way point: bends [rad], shape (K, S, 2), and the cost of being there, shape (K,)."""

    place: int
    bends: Array
    cost: Array
    barred: list[tuple[int, Array]] = field(default_factory=list)
    """Steps to the next layer that are known to be jumps: from a sample, to bends."""

    def bar(self, sample: int, bends: Array) -> None:
        """Take a step to bends of the next layer for a jump from now on."""
        if not any(k == sample and np.array_equal(to, bends) for k, to in self.barred):
            self.barred.append((sample, bends))


def layers(
    goals: Goals, backbone: Backbone, places: Array, choose: Choice, near: Array | None, each: int
) -> list[Layer]:
    """Return the samples at way points of a path, given by their places in `goals`; `each` about at each.

    Where there is none, the target is out of reach: the one sample is the nearest pose.
    """
    at = goals.take(places)
    bends, row = _samples(at, backbone, each)
    carried, to = _carried(at, backbone, bends, row)
    bends, row = np.concatenate([bends, carried]), np.concatenate([row, to])
    none = np.setdiff1d(np.arange(len(places)), row)
    left = at.take(none)
    nearest = solve(left.position, backbone, left.direction, left.rotation).bends
    out = []
    for i, place in enumerate(places):
        samples = bends[row == i] if i not in none else nearest[none == i]
        cost = np.zeros(len(samples))
        if choose != "nearest":
            cost = _CHOICE * penalty(samples, backbone, choose)
        elif near is not None and i == 0:
            # `nearest` is the least motion alone; a reference counts where the path begins.
            cost = penalty(samples, backbone, choose, near) ** 2 * len(places)
        out.append(Layer(int(place), samples, cost))
    return out


def _samples(goals: Goals, backbone: Backbone, each: int) -> tuple[Array, Index]:
    """Return samples of the solutions of each goal, shape (K, S, 2), and the goals that they are of, shape (K,)."""
    if len(backbone) == 2 and goals.conditions == 3:
        return family_samples(goals.position, backbone, each)
    if goals.rotation is not None and in_closed_form(goals, backbone):
        bends, _ = all_poses(goals.position, goals.rotation, backbone)
        row, column = np.nonzero(np.isfinite(bends[..., 0, 0]))
        return bends[row, column], row
    row = np.repeat(np.arange(len(goals)), each)
    own, start = goals.take(row), np.tile(spread(each, backbone), (len(goals), 1, 1))
    found = clamped(descend(own, backbone, start, steps=_STEPS), backbone)
    good = own.solved(found, backbone)
    return found[good], row[good]


def _carried(goals: Goals, backbone: Backbone, bends: Array, row: Index) -> tuple[Array, Index]:
    """Return where samples lead to at the goals before and after their own, and those goals."""
    found, to = np.concatenate([bends, bends]), np.concatenate([row - 1, row + 1])
    inside = (to >= 0) & (to < len(goals))
    found, to = found[inside], to[inside]
    own = goals.take(to)
    moved = descend(own, backbone, found, steps=10, near=True)
    close = np.sqrt(((moved - found) ** 2).sum(axis=(-1, -2))) < FARTHEST_STEP
    close &= own.solved(moved, backbone)
    return moved[close], to[close]


def shortest(chain: list[Layer]) -> list[int]:
    """Return the sample of each layer on the shortest way."""
    weight = float(len(chain))
    total, before = chain[0].cost / weight, []
    for last, layer in pairwise(chain):
        square = _squares(last.bends, layer.bends)
        jump = square > FARTHEST_STEP**2
        for sample, bends in last.barred:
            jump[sample] |= (np.abs(layer.bends - bends) < 1e-9).all(axis=(-1, -2))
        cost = total[:, None] + weight * square + np.where(jump, JUMP, 0.0)
        before.append(cost.argmin(axis=0))
        total = cost.min(axis=0) + layer.cost / weight
    way = [int(total.argmin())]
    for best in reversed(before):
        way.append(int(best[way[-1]]))
    return way[::-1]


def _squares(a: Array, b: Array) -> Array:
    a, b = a.reshape(len(a), -1), b.reshape(len(b), -1)
    return np.asarray(np.maximum((a**2).sum(1)[:, None] + (b**2).sum(1) - 2 * (a @ b.T), 0.0))

"""Which poses of a family are clear: samples of its curves, then the stretches between them that may hold one.

A clearance changes by no more than the arm moves (distances have slope 1 at most). On a stretch between two poses that
are `motion` apart it can therefore exceed the mean of both clearances by half of `motion`, and no more. A stretch on
which that is less than the margin holds no clear pose and is left out; the others are cut in four, down to `FINEST`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import clamped
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.planning.clearance import Clearance, Nearest

FINEST = 2e-4
"""Motion of the arm from one pose to the next at which no pose is looked for between them [m]."""

_PARTS = 4
_MOST = 150  # stretches that are cut at a time, the clearest first: it bounds the time of a search
_ROUNDABOUT = 1.1  # how much longer a curve is, at most, than the straight way between two of its samples
_STEPS = 8  # least-squares steps back onto the curve
_LEVELS = 8


@dataclass(frozen=True)
class Found:
    """What was found of a family: a clear pose or none, and the clearest pose that was seen.

    Attributes:
        bends: of the clear pose that is best by the choice [rad], shape (S, 2), or None.
        nearest: where this is nearest to an object, or where the clearest is.
        looked: how many poses were looked at.
        whole: whether all stretches that might hold a clear pose were looked at.
    """

    bends: Array | None
    nearest: Nearest
    looked: int
    whole: bool


class Search:
    """A search for the best clear pose among many; `penalty` says which is best, the least."""

    def __init__(
        self, clearance: Clearance, backbone: Backbone, margin: float, goal: Goals, penalty: Callable[[Array], Array]
    ) -> None:
        self.clearance, self.backbone, self.margin, self.goal = clearance, backbone, margin, goal
        self.penalty, self.looked, self.clearest = penalty, 0, (-np.inf, np.zeros((len(backbone), 2)))

    def look(self, bends: Array, places: Array | None = None) -> Array:
        """Return rough clearances of poses [m], shape (K,), and remember the clearest."""
        rough = self.clearance.rough(bends, self.margin, places)
        self.looked += len(bends)
        if len(rough) and rough.max() > self.clearest[0]:
            self.clearest = float(rough.max()), bends[int(rough.argmax())]
        return rough

    def best(self, bends: Array, rough: Array) -> tuple[Array, Nearest] | None:
        """Return the best of the poses that are clear to the surface, or None."""
        clear = np.flatnonzero(rough >= self.margin)
        for k in clear[np.argsort(self.penalty(bends[clear]), kind="stable")]:
            nearest = self.clearance.nearest(bends[k])
            if nearest.clearance >= self.margin:
                return bends[k], nearest
        return None

    def ended(self, found: tuple[Array, Nearest] | None, whole: bool) -> Found:
        """Return what came of it."""
        if found is not None:
            return Found(*found, self.looked, True)
        return Found(None, self.clearance.nearest(self.clearest[1]), self.looked, whole)

    def along(self, curves: list[Array]) -> Found:
        """Return the best clear pose of curves of solutions, each of shape (K, S, 2)."""
        bends = np.concatenate(curves)
        places = self.clearance.tube.places(bends)
        rough = self.look(bends, places)
        found = self.best(bends, rough)
        if found is not None:
            return self.ended(found, True)
        ends = np.cumsum([len(curve) for curve in curves])
        left = np.setdiff1d(np.arange(len(bends) - 1), ends - 1)
        stretches = np.stack([bends[left], bends[left + 1]], axis=1)
        motion = _motion(places[left], places[left + 1])
        return self._between(stretches, np.stack([rough[left], rough[left + 1]], axis=1), motion)

    def _between(self, stretches: Array, rough: Array, motion: Array) -> Found:
        """Return the best clear pose within stretches between two poses, shape (K, 2, S, 2)."""
        whole = True
        for _ in range(_LEVELS):
            most = rough.mean(axis=1) + 0.5 * _ROUNDABOUT * motion
            keep = np.flatnonzero((most >= self.margin) & (motion > FINEST))
            if len(keep) > _MOST:
                keep, whole = keep[np.argsort(-most[keep])[:_MOST]], False
            if not len(keep):
                return self.ended(None, whole)
            row = np.repeat(keep, _PARTS - 1)
            share = np.tile(np.arange(1, _PARTS) / _PARTS, len(keep))[:, None, None]
            inner = self._onto((1 - share) * stretches[row, 0] + share * stretches[row, 1])
            places = self.clearance.tube.places(inner)
            seen = self.look(inner, places)
            good = self.goal.take(np.zeros(len(inner), dtype=int)).solved(inner, self.backbone)
            found = self.best(inner[good], seen[good])
            if found is not None:
                return self.ended(found, True)
            chain = np.concatenate([stretches[keep, None, 0], _by(inner, keep), stretches[keep, None, 1]], axis=1)
            levels = np.concatenate([rough[keep, None, 0], _by(seen, keep), rough[keep, None, 1]], axis=1)
            stretches = np.stack([chain[:, :-1], chain[:, 1:]], axis=2).reshape(-1, 2, *chain.shape[2:])
            rough = np.stack([levels[:, :-1], levels[:, 1:]], axis=2).reshape(-1, 2)
            motion = _motion(*(self.clearance.tube.places(x) for x in (stretches[:, 0], stretches[:, 1])))
        return self.ended(None, False)

    def _onto(self, bends: Array) -> Array:
        """Return the solutions nearest to bends, shape (K, S, 2)."""
        goals = self.goal.take(np.zeros(len(bends), dtype=int))
        return clamped(descend(goals, self.backbone, bends, steps=_STEPS, near=True), self.backbone)


def _by(values: Array, keep: Index) -> Array:
    return values.reshape(len(keep), _PARTS - 1, *values.shape[1:])


def _motion(one: Array, other: Array) -> Array:
    """Return the longest way from place to place, shape (K,), of places (K, M + 1, 3)."""
    return np.asarray(np.sqrt(((one - other) ** 2).sum(axis=-1).max(axis=-1)))

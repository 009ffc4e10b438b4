"""The search for a course along targets: a continuous way through the redundancy, around the objects.

At way points along the targets samples of the solutions are taken, and those that are blocked left out. Of all ways
through the rest dynamic programming takes the one of least motion, with a price for coming nearer than twice the
margin. It is followed in small steps; where it jumps or is blocked on the way, that step is barred, and the way chosen
anew.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from contarm_sim.errors import BlockedError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.kinematics.inverse.tracking import courses, roadmap
from contarm_sim.model.arm import Arm
from contarm_sim.planning.avoid import avoid
from contarm_sim.planning.clearance import Clearance

SPACING = 0.05
"""Distance between way points at most, as a fraction of the arm's length."""

# Chosen by trial; there is no theory.
_FINE = 10  # steps from a way point to the next, at least
_SAMPLES = {1: 48}  # about so many at a way point on each branch, by the number of free parameters
_MANY = 96
_MOST_PLACES = 400
_PRICE = 2.0  # of touching the margin at a way point, beside squares of motions [rad^2]
_DEARER = 0.15  # as much longer a step counts from then on whose ends were those of a barred one [rad]
_KEPT, _SIDESTEP = 160, 0.25  # samples that are carried on at most; how far beside their ways others are tried [rad]
_ROUNDS = 40
_WIDTHS = (4.0, 2.0, 1.0, 0.5)  # of smoothing, in way points


class Way:
    """The search for one course."""

    def __init__(
        self, arm: Arm, clearance: Clearance, goals: Goals, inner: float, margin: float, start: Array | None
    ) -> None:
        self.arm, self.clearance, self.backbone, self.goals = arm, clearance, clearance.backbone, goals
        self.inner, self.margin = inner, margin
        along = np.concatenate([[0.0], np.cumsum(courses.strides(goals, arm.length))])
        count = int(np.clip(np.ceil(along[-1] / SPACING), 1, _MOST_PLACES))
        self.times = int(np.ceil(_FINE * count / (len(goals) - 1)))
        self.fine = courses.finer(goals, self.times)
        along = np.interp(np.arange(len(self.fine)) / self.times, np.arange(len(goals)), along)
        at = np.searchsorted(along, np.linspace(0, along[-1], count + 1)).clip(0, len(self.fine) - 1)
        self.places = np.unique(np.concatenate([[0], at, [len(self.fine) - 1]]))
        self.chain = self._layers(start)

    def _layers(self, start: Array | None) -> list[roadmap.Layer]:
        """Return the clear samples at way points, dearer where they are near to the margin."""
        each = _SAMPLES.get(2 * len(self.backbone) - 3, _MANY)
        chain = roadmap.layers(self.fine, self.backbone, self.places, "nearest", None, each)
        if start is not None:
            found = descend(self.fine.take([0]), self.backbone, start[None])
            chain[0].bends, chain[0].cost = found, np.zeros(1)
        for layer in chain:
            rough = self.clearance.rough(layer.bends, self.inner + max(self.margin, 1e-3))
            clear = rough >= self.inner
            if not clear.any():
                layer.bends = self._by_search(layer, start)
                rough, clear = self.clearance.rough(layer.bends, self.inner), np.ones(1, dtype=bool)
            layer.bends, layer.cost = layer.bends[clear], self._price(rough[clear])
        if 2 * len(self.backbone) - 3 > 1:
            self._carry(chain)
            self._carry(chain[::-1])
        return chain

    def _price(self, rough: Array) -> Array:
        """Return what it costs to be as near to objects as this, shape (K,)."""
        return np.asarray(_PRICE * np.clip(1 - (rough - self.inner) / max(self.margin, 1e-3), 0.0, 1.0) ** 2)

    def _carry(self, chain: list[roadmap.Layer]) -> None:
        """Add to each way point where the clear samples of the one before lead to, as they are and a step aside.

        Samples of many free parameters lie too far apart to be joined otherwise.
        """
        rng = np.random.default_rng(0)
        for last, layer in pairwise(chain):
            start = last.bends[np.argsort(last.cost, kind="stable")[:_KEPT]]
            aside = rng.normal(size=start.shape)
            aside *= _SIDESTEP / np.sqrt((aside**2).sum(axis=(-1, -2), keepdims=True))
            start = np.concatenate([start, start + aside])
            goals = self.fine.take(np.full(len(start), layer.place))
            moved = courses.follow(goals, self.backbone, start)
            moved = moved[goals.solved(moved, self.backbone)]
            rough = self.clearance.rough(moved, self.inner + max(self.margin, 1e-3))
            clear = rough >= self.inner
            layer.bends = np.concatenate([layer.bends, moved[clear]])
            layer.cost = np.concatenate([layer.cost, self._price(rough[clear])])

    def _by_search(self, layer: roadmap.Layer, start: Array | None) -> Array:
        """Return a clear pose at a way point where no sample is one, shape (1, S, 2).

        Raises:
            BlockedError: there is none, or the start is not clear.
        """
        where = self._said(layer.place)
        if start is not None and layer.place == 0:
            nearest = self.clearance.nearest(layer.bends[0])
            said = f"the pose that the start leads to is {1e3 * nearest.clearance:.4g} mm from {nearest.object!r}, "
            said += f"and {1e3 * self.margin:.4g} mm were asked for"
            raise BlockedError(said, nearest.clearance, self.margin, nearest.object)
        here = self.fine.position[layer.place]
        try:
            found = avoid(self.arm, here, self.margin)
            return avoid(self.arm, here, self.inner).bends[None]
        except BlockedError as error:
            clearest, said = error, str(error)
        if clearest.margin > self.margin:  # the second of them
            said = (
                f"poses are clear by {1e3 * found.clearance:.4g} mm there, and a course that is to be clear by "
                f"{1e3 * self.margin:.4g} mm between its samples, too, needs {1e3 * self.inner:.4g} mm at them"
            )
        raise BlockedError(f"{where}: {said}", clearest.clearance, self.margin, clearest.object)

    def course(self) -> Array:
        """Return bends for each goal, shape (T, S, 2).

        Raises:
            BlockedError: no way was found.
        """
        worst: tuple[int, Array] | None = None
        dearer = (_DEARER * len(self.chain)) ** 2  # as `shortest` weighs costs and motions
        for _ in range(_ROUNDS):
            way = roadmap.shortest(self.chain)
            nodes = np.array([layer.bends[k] for layer, k in zip(self.chain, way, strict=True)])
            apart = np.flatnonzero(self._barred(way, nodes))
            if len(apart):
                raise self._parted(int(self.places[apart[0] + 1]), worst)
            course = courses.follow(self.fine, self.backbone, _between(self.places, nodes, len(self.fine)))
            course[self.places] = nodes
            faults = self._faults(course)
            if not len(faults):
                return self._finished(course)
            worst = int(faults[0]), course[faults[0]]
            for i in np.unique(np.clip(np.searchsorted(self.places, faults) - 1, 0, len(self.chain) - 2)).tolist():
                self.chain[i].bar(way[i], nodes[i + 1])
                self.chain[i].cost[way[i]] += dearer
                self.chain[i + 1].cost[way[i + 1]] += dearer
        assert worst is not None
        raise self._parted(worst[0], worst)

    def _barred(self, way: list[int], nodes: Array) -> Any:
        """Return which steps of a way are barred, and were taken all the same."""
        out = np.zeros(len(nodes) - 1, dtype=bool)
        for i, layer in enumerate(self.chain[:-1]):
            out[i] = any(k == way[i] and np.abs(to - nodes[i + 1]).max() < 1e-9 for k, to in layer.barred)
        return out

    def _faults(self, course: Array) -> Index:
        """Return the places of a course that miss their goals, are blocked, or are jumped to."""
        wrong = ~self.fine.solved(course, self.backbone) | (self.clearance.rough(course, self.inner) < self.inner)
        return np.union1d(np.flatnonzero(wrong), courses.jumps(self.fine, self.backbone, course)).astype(np.intp)

    def _finished(self, course: Array) -> Array:
        """Return a course as smooth as it stays clear, at the goals."""
        width = len(self.fine) / len(self.places)
        for share in _WIDTHS:
            new = courses.smoothed(self.fine, self.backbone, course, share * width)
            if not len(self._faults(new)):
                course = new
        goals, course = self.goals, course[:: self.times]
        closer = descend(goals, self.backbone, course, limited=0.0, steps=8, near=True)
        better = goals.solved(closer, self.backbone) & (np.abs(closer - course).max(axis=(-1, -2)) < 1e-6)
        return np.where(better[:, None, None], closer, course)

    def _said(self, place: int) -> str:
        return said_of_target(place // self.times, len(self.goals))

    def _parted(self, place: int, worst: tuple[int, Array] | None) -> BlockedError:
        """Return the error that says that no continuous way goes on to a place."""
        bends = self.chain[0].bends[0] if worst is None else worst[1]
        nearest = self.clearance.nearest(bends)
        last = f"; the last that was tried came {1e3 * nearest.clearance:.4g} mm near to {nearest.object!r}"
        last = "" if worst is None else last
        return BlockedError(
            f"{self._said(place)}: there are poses clear by {1e3 * self.margin:.4g} mm, but no continuous way to them "
            f"was found{last}",
            nearest.clearance, self.margin, nearest.object,
        )  # fmt: skip


def said_of_target(number: int, count: int) -> str:
    """Return what a message about one of many targets begins with."""
    return f"target {number + 1} of {count}"


def _between(places: Array, nodes: Array, count: int) -> Array:
    """Return poses on straight lines between way points, shape (count, S, 2)."""
    flat = nodes.reshape(len(nodes), -1)
    columns = [np.interp(np.arange(count), places, column) for column in flat.T]
    return np.stack(columns, axis=-1).reshape(count, *nodes.shape[1:])

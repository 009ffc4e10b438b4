"""Where the arm's tube is nearest to objects: gaps, how they change with the joint angles, and how that changes.

A gap is the least distance over the places that a contact can slide to. So its first derivative is that of the place
alone, and the second has a part of the sliding.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.statics.leaning.surroundings import Surroundings
from contarm_sim.statics.leaning.tube import Attached, Place, Tube

Indices = NDArray[np.integer]

SAMPLES = 4
"""Places looked at in each span between stations."""

LEVEL = 0.2
"""Most slope of the distance along a backbone that lies along an object: such stations are watched beside minima."""

LYING = 3e-7
"""Most difference of gaps in a span that lies flat on an object [lengths]."""

APART = 0.2
"""How near a minimum stands for a station [spans]."""


@dataclass(frozen=True)
class Near:
    """Where the tube is nearest to an object.

    Attributes:
        number: of the object.
        place: on the tube.
        normal: out of the object, shape (3,).
        point: on the arm's surface [m], shape (3,).
        gap: between the surfaces [m], negative where they overlap.
    """

    number: int
    place: Place
    normal: Array
    point: Array
    gap: float


class Chain:
    """Positions and orientations of stations, and the hinges between them, at one pose.

    Args:
        x, R: of the stations [m], shape (K, 3) and (K, 3, 3).
        axes, anchors: of the hinges [m], shape (dofs, 3).
        station_of_dof: what each turns, shape (dofs,).
    """

    def __init__(self, x: Array, R: Array, axes: Array, anchors: Array, station_of_dof: Indices) -> None:
        self.x, self.R, self.axes, self.anchors, self.station_of_dof = x, R, axes, anchors, station_of_dof

    def levers(self, near: Near) -> Array:
        """Return the levers of a nearest place about the hinges [m], shape (dofs, 3)."""
        return near.place.point.arms(self.x, self.R, self.anchors, self.station_of_dof)

    def slope(self, near: Near) -> Array:
        """Return how a gap changes with the joint angles [m/rad], shape (dofs,)."""
        return np.asarray(np.cross(self.axes, self.levers(near)) @ near.normal)

    def surface_motion(self, near: Near) -> Array:
        """Return how the arm's surface moves at a nearest place with the joint angles [m/rad], shape (3, dofs)."""
        station = near.place.station
        turned = (self.station_of_dof <= station)[:, None] * self.axes
        return (np.cross(self.axes, self.levers(near)) - near.place.radius * np.cross(turned, near.normal)).T

    def second(self, near: Near, surroundings: Surroundings) -> Array:
        """Return the second derivative of a gap [m/rad^2], shape (dofs, dofs)."""
        n, place, levers = near.normal, near.place, self.levers(near)
        moved = np.cross(self.axes, levers)
        H = surroundings.curvature(near.number, place.point.at(self.x, self.R), place.radius)
        turned = levers * (self.axes @ n)[:, None] - self.axes * (levers @ n)[:, None]
        G = np.triu(self.axes @ turned.T)  # the hinge nearer to the base first
        G = G + np.triu(G, 1).T + moved @ H @ moved.T
        if not place.first:
            return np.asarray(G)
        along = np.array([each.at(self.x, self.R) for each in place.first])
        across = np.array([self._rates(each) @ n for each in place.first]) + along @ H @ moved.T
        bent = np.array([[n @ each.at(self.x, self.R) for each in row] for row in place.second]) + along @ H @ along.T
        bent -= place.radius_second
        return np.asarray(G - across.T @ np.linalg.solve(bent, across))

    def _rates(self, each: Attached) -> Array:
        return np.cross(self.axes, each.arms(self.x, self.R, self.anchors, self.station_of_dof))


def nearest(
    tube: Tube, chain: Chain, surroundings: Surroundings, within: float, flat: set[tuple[int, int]]
) -> list[Near]:
    """Return where the tube is nearest to the objects, of those that are within a distance [m].

    Args:
        flat: spans that lie flat on an object, (object, span): there stations stand for what is between them. Those
            that are found to do so are added.
    """
    found: list[Near] = []
    for number in range(len(surroundings.objects)):
        look = _Look(tube, chain, surroundings, number, flat)
        if surroundings.reach(number, chain.x).min() < within + tube.radii.max() + np.diff(tube.along).max():
            found += [near for place in look.places(within) if (near := look.near(place)).gap < within]
    return found


class _Look:
    """What is near to one object."""

    def __init__(self, tube: Tube, chain: Chain, surroundings: Surroundings, number: int, flat: set[Any]) -> None:
        self._tube, self._x, self._R = tube, chain.x, chain.R
        self._distances = lambda points: surroundings.distances(number, points)
        self._number, self._flat = number, flat

    def near(self, place: Place) -> Near:
        """Return what there is to say of a place."""
        centre = place.point.at(self._x, self._R)
        (distance,), (normal,) = self._distances(centre[None])
        return Near(self._number, place, normal, centre - place.radius * normal, float(distance) - place.radius)

    def places(self, within: float) -> Iterator[Place]:
        """Return the places that are nearer than those about them."""
        yield from self._along(within)
        yield self._tube.ball

    def _along(self, within: float) -> Iterator[Place]:
        tube, spans = self._tube, np.arange(self._tube.last)
        points, along, radii = tube.points(self._x, self._R, np.append(spans, spans[-1]), np.append(0.0 * spans, 1.0))
        away, normals = self._distances(points)
        level = np.abs((normals * along).sum(axis=1)) < LEVEL
        gaps = away - radii[:, 0]
        close = np.minimum(gaps[:-1], gaps[1:]) - np.diff(tube.along) < within
        watched = (gaps < within) & level
        end, share = tube.end
        close[end + 1 :], watched[end + 1 :], watched[0] = False, False, False
        for first, last in _runs(close):
            run = np.arange(first, last)
            of, u = np.repeat(run, SAMPLES), np.tile(np.arange(SAMPLES) / SAMPLES, len(run))
            stop = share if last - 1 == end else 1.0
            before = (of < last - 1) | (u < stop)
            of, u = np.append(of[before], last - 1), np.append(u[before], stop)
            slopes = self._slopes(of, u)
            ends = last - 1 == end and slopes[-1] < LEVEL
            for k in np.flatnonzero((slopes[:-1] < 0) & (slopes[1:] >= 0)):
                span, low = int(of[k]), float(u[k])
                high = min(low + 1 / SAMPLES, stop if span == last - 1 else 1.0)
                where = _root(partial(self._slope, span), low, high)
                place = tube.place(span, where)
                if (self._number, span) in self._flat or self._lies(place, gaps[span : span + 2]):
                    self._flat.add((self._number, span))
                    continue
                watched[span + int(where > 0.5)] &= abs(where - 0.5) < 0.5 - APART
                ends = ends and end + share - span - where > APART
                yield place
            if ends:
                watched[end + int(share > 0.5)] &= abs(share - 0.5) < 0.5 - APART
                yield tube.fixed(tube.place(end, share))
        for station in np.flatnonzero(watched):
            yield tube.fixed(tube.place(int(station), 0.0))

    def _slope(self, span: int, u: float) -> float:
        return float(self._slopes(np.array([span]), np.array([u]))[0])

    def _lies(self, place: Place, gaps: Array) -> bool:
        """Whether a span about a minimum lies flat: the gaps [m] at its stations are hardly larger."""
        return bool(gaps.max() - self.near(place).gap < LYING * self._tube.length)

    def _slopes(self, spans: Indices, u: Array) -> Array:
        """Return how the gap changes along the backbone, shape (S,)."""
        points, along, radii = self._tube.points(self._x, self._R, spans, u)
        return np.asarray((self._distances(points)[1] * along).sum(axis=1) - radii[:, 1])


def _runs(mask: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Return the starts and ends of runs of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function that rises from below zero to above is zero."""
    from scipy.optimize import brentq

    if function(high) <= 0:
        return high
    return float(brentq(function, low, high, xtol=1e-14, rtol=1e-15))

"""The arm's outside as a smooth tube about its backbone, closed by a ball at the tip, as in motion.

The links of a chain touch with their ends, so that a force jumps by a whole pitch where the load changes a little, and
poses converge in the first order of the pitch. The quadratic spline whose control points are the joints meets each
station along its link, and is as near to the rod as the chain is: with it poses converge in the second order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array

Indices = NDArray[np.integer]

NECK = 0.25
"""How far before the middle of the tip's ball the tube ends [radii].

The ball is fixed to the tip, as in motion: in an arm of curvature k its middle is k r^2/2 off the backbone, and a tube
that went on up to there would touch what a curled tip is pressed on before the ball does.
"""


@dataclass(frozen=True)
class Attached:
    """A point or a direction that some stations carry: sum of weight x + R offset over them.

    Attributes:
        stations: which, shape (P,).
        weights: 1 for points, 0 for directions, shape (P,); those of a point add up to 1.
        offsets: in the stations' frames [m], shape (P, 3).
    """

    stations: Indices
    weights: Array
    offsets: Array

    def at(self, x: Array, R: Array) -> Array:
        """Return it in the base frame [m], shape (3,), of stations at x, shape (K, 3), turned by R, (K, 3, 3)."""
        return np.asarray(self.weights @ x[self.stations] + self._turned(R).sum(axis=0))

    def arms(self, x: Array, R: Array, anchors: Array, station_of_dof: Indices) -> Array:
        """Return the lever about each hinge [m], shape (dofs, 3): it moves by axis x lever times the hinge's rate."""
        carried = (self.stations[None, :] >= station_of_dof[:, None])[..., None]
        places = self.weights[:, None] * x[self.stations] + self._turned(R)
        levers = places[None] - self.weights[None, :, None] * anchors[:, None, :]
        return np.asarray((carried * levers).sum(axis=1))

    def _turned(self, R: Array) -> Array:
        return np.asarray((R[self.stations] @ self.offsets[..., None])[..., 0])


@dataclass(frozen=True)
class Place:
    """A place on the tube's backbone or the tip's ball, by the arc length that a contact slides along.

    Attributes:
        point: where.
        first: how it moves by arc length; empty if the place is fixed to the arm.
        second: how that changes, a list of lists.
        radius: of the tube there, or of the ball [m].
        radius_first, radius_second: how it changes by arc length; 0 if fixed.
        along: arc length [m], that of the tip for its ball.
        station: the station next to it.
    """

    point: Attached
    first: tuple[Attached, ...]
    second: tuple[tuple[Attached, ...], ...]
    radius: float
    radius_first: float
    radius_second: float
    along: float
    station: int


class Tube:
    """The tube of an arm.

    Args:
        stations: arc lengths of the stations [m], shape (K,).
        radii: of the tube there [m], shape (K,).

    Attributes:
        ball: the tip's, which ends with its plate.
        end: the span where the tube ends, just before the ball's middle, and where in it, 0 to 1.
    """

    def __init__(self, stations: Array, radii: Array) -> None:
        self.along, self.radii = stations, radii
        self.last = len(stations) - 1
        self.length = float(stations[-1])
        radius = float(radii[-1])
        self.ball = Place(
            point=Attached(np.array([self.last]), np.ones(1), np.array([[0.0, 0.0, -radius]])),
            first=(), second=(), radius=radius, radius_first=0.0, radius_second=0.0,
            along=self.length, station=self.last,
        )  # fmt: skip
        end = self.length - (1 + NECK) * radius
        span = int(np.clip(np.searchsorted(stations, end) - 1, 0, self.last - 1))
        self.end = span, float(max(0.0, (end - stations[span]) / (stations[span + 1] - stations[span])))

    def points(self, x: Array, R: Array, spans: Indices, u: Array) -> tuple[Array, Array, Array]:
        """Return points of the backbone [m], their directions by arc length, and radii [m] less their slopes.

        Args:
            x, R: positions [m] and orientations of the stations, shape (K, 3) and (K, 3, 3).
            spans: which spans between stations, shape (S,).
            u: where in each, 0 to 1, shape (S,).
        """
        h = np.diff(self.along)[spans][:, None]
        below, above, u = R[spans, :, 2], R[spans + 1, :, 2], u[:, None]
        points = x[spans] + h * (u - 0.5 * u * u) * below + h * 0.5 * u * u * above
        low, step = self.radii[spans][:, None], np.diff(self.radii)[spans][:, None]
        radii = np.concatenate([low + step * u * u * (3 - 2 * u), 6 * step * u * (1 - u) / h], axis=1)
        return points, (1 - u) * below + u * above, radii

    def place(self, span: int, u: float) -> Place:
        """Return the place at u, 0 to 1, of a span between stations; its parameter is arc length."""
        h = float(self.along[span + 1] - self.along[span])
        two, step = np.array([span, span + 1]), float(self.radii[span + 1] - self.radii[span])

        def of(weight: float, below: float, above: float) -> Attached:
            return Attached(two, np.array([weight, 0.0]), np.array([[0, 0, below], [0, 0, above]]))

        return Place(
            point=of(1.0, h * (u - 0.5 * u * u), 0.5 * h * u * u),
            first=(of(0.0, 1 - u, u),),
            second=((of(0.0, -1 / h, 1 / h),),),
            radius=float(self.radii[span] + step * u * u * (3 - 2 * u)),
            radius_first=6 * step * u * (1 - u) / h,
            radius_second=6 * step * (1 - 2 * u) / h**2,
            along=float(self.along[span]) + h * u,
            station=span + int(u > 0.5),
        )

    def fixed(self, place: Place) -> Place:
        """Return the same place without parameters: a contact there does not slide."""
        return Place(place.point, (), (), place.radius, 0.0, 0.0, place.along, place.station)

"""Which of the many poses that reach a point an arm of several sections takes, without a jump from one to the next."""

from __future__ import annotations

from typing import Literal

import numpy as np

from contarm_sim.kinematics import inverse, sections
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.checks import one_goal
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.general.settling import settle
from contarm_sim.kinematics.inverse.limits import clamped
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm

Taken = Literal["nearest", "least bend"]
TAKEN: tuple[Taken, ...] = ("nearest", "least bend")

_STRIDE = 0.05
"""Longest way that a tip is led at once [lengths]: the pose then stays on its branch."""

_MOST_STRIDES, _STEPS = 8, 15
"""Strides of one pull, and steps of each stride, at most: a pull never takes long."""

_SETTLING = 6
_ROOM = 1e-3  # rad, of bends below their limits
_POINTS = 61


class Redundancy:
    """Leads an arm from pose to pose.

    Args:
        arm: of two sections or more.

    Attributes:
        taken: `nearest`: to the pose before; `least bend`: bends whose squares sum to the least nearby.
        direction: that the tip keeps, shape (3,), or None; takes three sections or more.
    """

    def __init__(self, arm: Arm) -> None:
        self.backbone = shape.backbone(arm)
        self.taken: Taken = "nearest"
        self.direction: Array | None = None
        self._curve: Array | None = None

    def tip(self, bend: Array) -> Array:
        """Return where the tip of the arcs is [m], shape (3,), at bends [rad], shape (2 S,)."""
        return sections.position(self._bends(bend), self.backbone)

    def pull(self, bend: Array, point: Array) -> Array:
        """Return the bends [rad], shape (2 S,), that a tip pulled to a point [m] comes to, or as near as it can.

        Args:
            bend: those that it comes from.
        """
        self._curve = None
        bends = clamped(self._bends(bend), self.backbone)
        start = self.tip(bend)
        strides = int(
            np.clip(np.ceil(np.linalg.norm(point - start) / (_STRIDE * self.backbone.length)), 1, _MOST_STRIDES)
        )
        for share in np.arange(1, strides + 1) / strides:
            bends = self._led(bends, start + share * (point - start))
        if self.taken == "least bend" and self.direction is None:
            bends = self._settled(bends, point)
        return bends.reshape(-1)

    def nearest(self, bend: Array, point: Array) -> Array:
        """Return the bends [rad] nearest to some that reach a point [m]; where none does, those that come nearest."""
        found = inverse.solve(point, self.backbone, self.direction, choose="nearest", near=self._bends(bend))
        return np.asarray(found.bends.reshape(-1))

    def along(self, bend: Array, share: float) -> Array:
        """Return bends [rad], shape (4,), on the curve of poses of two sections that reach the tip of some bends.

        Args:
            share: of the curve, 0 to 1; a curve that is closed comes back to its beginning.
        """
        curve = self.curve(bend)
        place = share * (len(curve) - 1)
        flat = curve.reshape(len(curve), -1)
        mixed = np.array([np.interp(place, np.arange(len(curve)), column) for column in flat.T])
        return self._led(mixed.reshape(2, 2), self._point).reshape(-1)

    def share(self, bend: Array) -> float:
        """Return where bends lie on their curve, from 0 to 1."""
        curve = self.curve(bend)
        return float(np.abs(curve - self._bends(bend)).max(axis=(1, 2)).argmin()) / max(len(curve) - 1, 1)

    def curve(self, bend: Array) -> Array:
        """Return the curve that bends lie on, shape (K, 2, 2); it is kept until the next pull."""
        if self._curve is None:
            self._point = self.tip(bend)
            own = self._bends(bend)
            curves = [*inverse.solve_all(self._point, self.backbone, points=_POINTS), own[None]]
            self._curve = min(
                curves, key=lambda curve: float(np.abs(curve - own).max(axis=(1, 2)).min()) + 10 * (len(curve) < 2)
            )
        return self._curve

    def forget(self) -> None:
        """Take a new curve next time."""
        self._curve = None

    def _led(self, bends: Array, point: Array) -> Array:
        goals = one_goal(point, self.direction, None, self.backbone.length)
        led = descend(goals, self.backbone, bends[None], limited=1.0, steps=_STEPS, near=False)[0]
        return clamped(led, self.backbone)

    def _settled(self, bends: Array, point: Array) -> Array:
        """Go along the poses that reach the point, towards the straight arm."""
        goals, straight = one_goal(point, None, None, self.backbone.length), np.zeros_like(bends)
        return settle(goals, self.backbone, bends[None], "nearest", straight[None], _SETTLING)[0]

    def _bends(self, bend: Array) -> Array:
        return np.asarray(bend, dtype=float).reshape(len(self.backbone), 2)

"""What tips are to reach: positions, and directions or rotations beside them; how far bends are off, and its slopes.

Residuals are free of units: distances are divided by the backbone's length, angles count as `ANGLE_LENGTH`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.limits import excess
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH, TOLERANCE, Bool, Inverse
from contarm_sim.kinematics.inverse.rotations import between_directions, between_rotations
from contarm_sim.kinematics.inverse.tips import tips_and_jacobians


@dataclass(frozen=True)
class Goals:
    """Goals of n tips.

    Attributes:
        position: where the tips are to be [m], shape (n, 3).
        direction: unit vectors that the z axes of the tips are to have, shape (n, 3), or None.
        rotation: what the tips are to be turned by, shape (n, 3, 3), or None.
    """

    position: Array
    direction: Array | None = None
    rotation: Array | None = None

    def __len__(self) -> int:
        return len(self.position)

    @property
    def conditions(self) -> int:
        """How many numbers of a tip's pose are asked for: 3, 5 or 6."""
        return 3 if self.direction is None and self.rotation is None else 5 if self.rotation is None else 6

    def take(self, rows: Any) -> Goals:
        """Return some of the goals, by an index array, a mask or a slice."""
        direction = None if self.direction is None else self.direction[rows]
        rotation = None if self.rotation is None else self.rotation[rows]
        return Goals(self.position[rows], direction, rotation)

    def turn(self, rotation: Array) -> Array | None:
        """Return the rotation vectors that turn tips into what is asked for [rad], shape (n, 3), or None."""
        if self.rotation is not None:
            return between_rotations(rotation, self.rotation)
        return None if self.direction is None else between_directions(rotation[..., 2], self.direction)

    def terms(self, bends: Array, backbone: Backbone) -> tuple[Array, Array]:
        """Return goal minus tip, free of units, (n, 3 or 6), and how it falls by the bends, (n, 3 or 6, 2 S).

        The slopes are exact where what is asked for is reached. Times the residual, they give the exact gradient of
        half its square everywhere.
        """
        position, rotation, slopes = tips_and_jacobians(bends, backbone)
        offset, turn = (self.position - position) / backbone.length, self.turn(rotation)
        if turn is None:
            return offset, slopes[:, :3] / backbone.length
        slopes[:, :3] /= backbone.length
        slopes[:, 3:] *= ANGLE_LENGTH
        if self.rotation is None:
            axis = rotation[..., 2]
            slopes[:, 3:] -= axis[:, :, None] * (axis[:, None, :] @ slopes[:, 3:])
        return np.concatenate([offset, ANGLE_LENGTH * turn], axis=-1), slopes

    def misses(self, bends: Array, backbone: Backbone) -> tuple[Array, Array]:
        """Return the distances [m] and angles [rad] that bends miss goals by, each of shape (n,)."""
        return self.apart(*tips_and_jacobians(bends, backbone)[:2])

    def apart(self, position: Array, rotation: Array) -> tuple[Array, Array]:
        """Return the distances [m] and angles [rad] from tips' positions and rotations to goals, each of shape (n,)."""
        x, y, z = (self.position - position).T
        distance, turn = np.hypot(np.hypot(x, y), z), self.turn(rotation)
        return distance, np.zeros(len(distance)) if turn is None else np.sqrt((turn**2).sum(axis=-1))

    def off(self, bends: Array, backbone: Backbone) -> Array:
        """Return distances and angles as one, the length of the residual, shape (n,)."""
        miss, angle = self.misses(bends, backbone)
        return np.asarray(np.hypot(miss / backbone.length, ANGLE_LENGTH * angle))

    def solved(self, bends: Array, backbone: Backbone) -> Bool:
        """Return whether bends reach goals within the tolerance and the limits, shape (n,), bool."""
        miss, angle = self.misses(bends, backbone)
        return np.asarray(_within(miss, angle, backbone) & (excess(bends, backbone) <= 0))

    def answered(self, bends: Array, backbone: Backbone, solutions: Any) -> Inverse:
        """Return bends as answers; `solutions` says how many there are of those that are reached."""
        return judged(bends, *self.misses(bends, backbone), backbone, solutions)


def judged(bends: Array, miss: Array, angle: Array, backbone: Backbone, solutions: Any) -> Inverse:
    """Return bends with known distances [m] and angles [rad] as answers."""
    within = _within(miss, angle, backbone)
    return Inverse(bends, miss, angle, within, np.where(within, solutions, 0).astype(np.intp))


def _within(miss: Array, angle: Array, backbone: Backbone) -> Bool:
    return np.asarray(np.maximum(miss, ANGLE_LENGTH * backbone.length * angle) <= TOLERANCE * backbone.length)

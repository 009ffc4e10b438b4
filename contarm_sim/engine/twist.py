"""What twist does to parallel muscles, which fixed tendons do not feel: they get longer, and pull back.

A muscle that bending leaves l of at a joint is a helix of length hypot(l, r a) when the joint twists by a; here
l + (r a)^2/(2 l), short by (r a/l)^2/4 of what twist adds: 1 % at 10 deg a joint of 24 links. Its tension T is a
stiffness r^2 T/l against twist (one that pushes takes it away), and unbends the joint a little.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

_LEAST = 0.2
"""Least share of a pitch that bending leaves of a muscle: joints bend so far on the way to a pose at most."""


class TwistedMuscles:
    """Parallel muscles of an arm with three hinges a joint.

    Args:
        by_angle: what muscle lengths gain by joint angles where nothing twists [m/rad], shape (3, dofs).
        twisting: the hinges that twist, one a joint, shape (links,).
        qpos: the joint angles [rad], shape (dofs,), as a view that stays current.
    """

    def __init__(self, arm: Arm, by_angle: Array, twisting: NDArray[np.integer], qpos: Array) -> None:
        self._arm, self._by_angle, self._twisting, self._qpos = arm, by_angle, twisting, qpos

    def left(self) -> Array:
        """Return what bending leaves of each muscle at each joint [m], shape (3, links)."""
        left = self._arm.link_pitch + (self._by_angle * self._qpos).reshape(3, -1, 3).sum(axis=2)
        return np.maximum(left, _LEAST * self._arm.link_pitch)

    def stretch(self) -> Array:
        """Return what twist adds to each muscle at each joint [m], shape (3, links)."""
        return np.square(self._arm.muscle_radius * self._qpos[self._twisting]) / (2 * self.left())

    def jacobian(self) -> Array:
        """Return what muscle lengths gain by joint angles [m/rad], shape (3, dofs)."""
        left = self.left()
        J = self._by_angle * (1 - np.repeat(self.stretch() / left, 3, axis=1))
        J[:, self._twisting] = self._arm.muscle_radius**2 * self._qpos[self._twisting] / left
        return J

    def joint_stiffness(self, tensions: Array) -> Array:
        """Return what tensions [N], shape (3,), add to the stiffness of joints against twist [N m/rad], (links,)."""
        return np.asarray(self._arm.muscle_radius**2 * (tensions[:, None] / self.left()).sum(axis=0))

    def against_twist(self) -> Array:
        """Return the moment against the present twist by tension [m], shape (3, dofs)."""
        moment = np.zeros((3, self._qpos.size))
        moment[:, self._twisting] = self._arm.muscle_radius**2 * self._qpos[self._twisting] / self.left()
        return moment

    def stiffness(self, tensions: Array) -> Array:
        """Return what tensions [N], shape (3,), add to the stiffness matrix [N m/rad], shape (dofs, dofs)."""
        left, angle = self.left(), self._qpos[self._twisting]
        by_angle = self._by_angle.reshape(3, -1, 3)
        pull = tensions[:, None] * self._arm.muscle_radius**2
        bend = np.einsum("mj,mja,mjb->jab", pull * angle**2 / left**3, by_angle, by_angle)
        mixed = -np.einsum("mj,mja->ja", pull * angle / left**2, by_angle)
        K = np.zeros((self._qpos.size, self._qpos.size))
        for joint, z in enumerate(self._twisting):
            own = slice(3 * joint, 3 * joint + 3)
            K[own, own] = bend[joint]
            K[own, z] += mixed[joint]
            K[z, own] += mixed[joint]
        K[self._twisting, self._twisting] += self.joint_stiffness(tensions)
        return K

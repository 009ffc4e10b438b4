"""What twist does to parallel muscles, which fixed tendons do not feel: they get longer, and pull back.

A muscle that bending leaves l of at a joint is a helix of length hypot(l, r a) when the joint twists by a; here
l + (r a)^2/(2 l), short by (r a/l)^2/4 of what twist adds: 1 % at 10 deg a joint of 24 links. Its tension T is a
stiffness r^2 T/l against twist (one that pushes takes it away), and unbends the joint a little.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contarm_sim.arm import Arm
from contarm_sim.kinematics.arrays import Array


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
        return self._arm.link_pitch + (self._by_angle * self._qpos).reshape(3, -1, 3).sum(axis=2)

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
        """Return the stiffness of joints against twist under tensions [N], shape (3,): [N m/rad], shape (links,)."""
        assert self._arm.torsional_stiffness is not None
        pulled = (tensions[:, None] / self.left()).sum(axis=0)
        return self._arm.torsional_stiffness / self._arm.link_pitch + self._arm.muscle_radius**2 * pulled

    def bending_forces(self, tensions: Array, slopes: Array) -> Array:
        """Return what twist adds to the generalised forces on bending hinges [N m], shape (dofs,).

        Args:
            tensions: of the muscles, as long as they are [N], shape (3,).
            slopes: what tensions gain by length [N/m], shape (3,): the engine's are those of shorter muscles.
        """
        stretch = self.stretch()
        change = tensions[:, None] * stretch / self.left() - (slopes * stretch.sum(axis=1))[:, None]
        return np.asarray((self._by_angle * np.repeat(change, 3, axis=1)).sum(axis=0))

    def coupling(self, tensions: Array) -> Array:
        """Return what tensions [N] add to the stiffness matrix beside `joint_stiffness`, shape (dofs, dofs)."""
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
        return K

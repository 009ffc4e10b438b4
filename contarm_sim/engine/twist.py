"""What twist does to parallel muscles, which fixed tendons do not feel: they get longer, and pull back.

A muscle that bending leaves l of at a joint is a helix of length hypot(l, r a) when the joint twists by a; here
l + (r a)^2/(2 l), short by (r a/l)^2/4 of what twist adds: 1 % at 10 deg a joint of 24 links. Its tension T is a
stiffness r^2 T/l against twist (one that pushes takes it away), and unbends the joint a little.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np

from contarm_sim.engine.index import ArmIndex
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

_LEAST = 0.2
"""Least share of a pitch that bending leaves of a muscle: joints bend so far on the way to a pose at most."""


class TwistedMuscles:
    """Parallel muscles of an arm whose joints twist, J of them with three hinges each.

    All may be of many arms at once, in a leading axis: see `of_many`.

    Args:
        arm: its parameters.
        index: where its hinges are, and what muscle lengths gain by their angles where nothing twists.
        qpos: the joint angles [rad], shape (dofs,), as a view that stays current.
    """

    def __init__(self, arm: Arm, index: ArmIndex, qpos: Array) -> None:
        self._by_angle, self._qpos = index.by_angle, qpos
        self._twisting, self._hinges = index.twisting, index.twisted
        sections = index.section_of_joint[index.twisting]
        self._pitch = np.array([[arm.sections[number].link_pitch for number in sections]])
        self._radius = np.array([
            [group.routing.radius * (group.crosses(number) and group.routing.path == "parallel") for number in sections]
            for group in arm.groups for _ in range(group.routing.count)
        ])  # fmt: skip
        self._square = self._radius**2
        self._by_hinge = self._by_angle[:, self._hinges]

    @classmethod
    def of_many(cls, each: Sequence[TwistedMuscles], qpos: Array) -> TwistedMuscles:
        """Return those of arms whose hinges are alike, with their joint angles [rad], shape (B, dofs)."""
        many = copy.copy(each[0])
        many._qpos = qpos
        for name in ("_by_angle", "_pitch", "_radius", "_square", "_by_hinge"):
            setattr(many, name, np.stack([getattr(one, name) for one in each]))
        return many

    def at(self, qpos: Array) -> TwistedMuscles:
        """Return the same at other joint angles [rad], shape (..., dofs), which stay current."""
        other = copy.copy(self)
        other._qpos = qpos
        return other

    def left(self) -> Array:
        """Return what bending leaves of each muscle at each joint [m], shape (..., M, J)."""
        turned = self._qpos[..., None, self._hinges]
        left = self._pitch + (self._by_hinge * turned).sum(axis=-1)
        return np.maximum(left, _LEAST * self._pitch)

    def stretch(self) -> Array:
        """Return what twist adds to each muscle at each joint [m], shape (..., M, J)."""
        return np.square(self._radius * self._qpos[..., None, self._twisting]) / (2 * self.left())

    def jacobian(self) -> Array:
        """Return what muscle lengths gain by joint angles [m/rad], shape (..., M, dofs)."""
        left, J = self.left(), self._by_angle * np.ones((*self._qpos.shape[:-1], 1, 1))
        J[..., self._hinges] *= (1 - self.stretch() / left)[..., None]
        J[..., self._twisting] = self._square * self._qpos[..., None, self._twisting] / left
        return J

    def joint_stiffness(self, tensions: Array) -> Array:
        """Return what tensions [N], shape (..., M), add to the stiffness of joints against twist [N m/rad]."""
        return np.asarray((self._square * (tensions[..., None] / self.left())).sum(axis=-2))

    def against_twist(self) -> Array:
        """Return the moment against the present twist by tension [m], shape (..., M, dofs)."""
        moment = np.zeros((*self._qpos.shape[:-1], *self._by_angle.shape[-2:]))
        moment[..., self._twisting] = self._square * self._qpos[..., None, self._twisting] / self.left()
        return moment

    def stiffness(self, tensions: Array) -> Array:
        """Return what tensions [N], shape (..., M), add to the stiffness matrix [N m/rad], shape (..., dofs, dofs)."""
        left, angle = self.left(), self._qpos[..., self._twisting]
        pull = tensions[..., None] * self._square
        turned = angle[..., None, :]
        bend = np.einsum("...mj,...mja,...mjb->...jab", pull * turned**2 / left**3, self._by_hinge, self._by_hinge)
        mixed = -np.einsum("...mj,...mja->...ja", pull * turned / left**2, self._by_hinge)
        K = np.zeros((*self._qpos.shape, self._qpos.shape[-1]))
        K[..., self._hinges[:, :, None], self._hinges[:, None, :]] = bend
        K[..., self._hinges, self._twisting[:, None]] += mixed
        K[..., self._twisting[:, None], self._hinges] += mixed
        K[..., self._twisting, self._twisting] += self.joint_stiffness(tensions)
        return K

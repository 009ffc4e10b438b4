"""Friction in the backbones of many arms: springs in series with sliders, which remember, see `Section`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contarm_sim.engine.index import ArmIndex
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm


def has_friction(arm: Arm) -> bool:
    """Whether friction in an arm's backbone remembers."""
    return any(section.friction_moment is not None for section in arm.sections)


class BackboneFriction:
    """What B arms of one layout hold in the springs of their J joints; D joint angles each.

    Args:
        arms: their parameters.
        index: where the parts of each are in the engine.

    Attributes:
        moment: of each joint about its hinges x and y [N m], shape (B, J, 2).
    """

    def __init__(self, arms: Sequence[Arm], index: ArmIndex) -> None:
        self._hinges = np.stack([index.bending["x"], index.bending["y"]], axis=-1)
        section = index.section_of_joint[index.bending["x"]]
        own = np.array([[(part.sticking_stiffness, part.friction_moment or 0.0) for part in a.sections] for a in arms])
        self._stiffness, self._slides = own[:, section, 0, None], own[:, section, 1]
        self.moment = np.zeros((len(arms), len(section), 2))
        self._before = np.zeros_like(self.moment)

    def start(self, qpos: Array) -> None:
        """Hold nothing at joint angles [rad], shape (B, D)."""
        self.moment[:] = 0.0
        self._before = qpos[:, self._hinges]

    def follow(self, qpos: Array) -> None:
        """Take up a small way to other joint angles [rad], shape (B, D); all is straight in between."""
        bends = qpos[:, self._hinges]
        moment = self.moment + self._stiffness * (bends - self._before)
        held = np.hypot(moment[..., 0], moment[..., 1])
        share = np.minimum(1.0, self._slides / np.maximum(held, 1e-300))
        self.moment, self._before = moment * share[..., None], bends

    def push(self, forces: Array) -> None:
        """Write what the joints feel of it into generalised forces [N m], shape (B, D)."""
        forces[:, self._hinges] = -self.moment

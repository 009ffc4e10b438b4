"""How a muscle looks: the thicker and the brighter the more it pulls."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

SLACK = np.array([0.55, 0.55, 0.57])
"""Colour of a muscle without tension."""


def thickness(share: Array) -> Array:
    """Return thickness over the largest, of muscles with a share of the largest tension, from 0 to 1."""
    return 0.6 + 0.4 * np.clip(share, 0.0, 1.0)


def tint(share: Array, colours: Array) -> Array:
    """Return colours, shape (M, 3), of muscles with shares of the largest tension, shape (M,); `colours`: at full."""
    return SLACK + (0.45 + 0.55 * np.clip(share, 0.0, 1.0))[:, None] * (colours - SLACK)


class Muscles:
    """The muscles of a model that is drawn: capsules on the links where they run parallel, else spatial tendons."""

    def __init__(self, model: Any, arm: Arm) -> None:
        from contarm_sim.mjcf.routing import COLOURS, MUSCLES

        self._model, self._colours = model, np.array(COLOURS)[:, :3]
        self._parallel = arm.muscle.path == "parallel"
        if self._parallel:
            names = [model.geom(i).name for i in range(model.ngeom)]
            self._geoms = [np.flatnonzero([name.endswith(muscle) for name in names]) for muscle in MUSCLES]
            self._materials = [model.material(muscle).id for muscle in MUSCLES]
            self._widths = np.array([model.geom_size[geoms[0], 0] for geoms in self._geoms])
        else:
            self._widths = model.tendon_width.copy()

    def show(self, share: Array) -> None:
        """Let the muscles look as their shares of the largest tension, shape (3,), say."""
        widths, colours = self._widths * thickness(share), tint(share, self._colours)
        if not self._parallel:
            self._model.tendon_width[:], self._model.tendon_rgba[:, :3] = widths, colours
            return
        for geoms, material, width, colour in zip(self._geoms, self._materials, widths, colours, strict=True):
            self._model.geom_size[geoms, 0] = width
            self._model.mat_rgba[material, :3] = colour

"""How a muscle looks: the thicker and the brighter the more it pulls."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.view.sections import muscle_colours

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
        from contarm_sim.engine.index import drawn_muscles
        from contarm_sim.mjcf import names

        muscles = names.muscles(arm)
        self._model, self._colours = model, muscle_colours(arm)
        self._geoms = drawn_muscles(model, arm)
        self._tendons = [model.tendon(name).id for name in muscles]
        self._widths = np.array([
            model.geom_size[geoms[0], 0] if geoms.size else model.tendon_width[tendon]
            for geoms, tendon in zip(self._geoms, self._tendons, strict=True)
        ])  # fmt: skip

    def show(self, share: Array) -> None:
        """Let the muscles look as their shares of the largest tension, one a muscle, say."""
        widths, colours = self._widths * thickness(share), tint(share, self._colours)
        for geoms, tendon, width, colour in zip(self._geoms, self._tendons, widths, colours, strict=True):
            if geoms.size:
                self._model.geom_size[geoms, 0] = width
                self._model.mat_rgba[self._model.geom_matid[geoms], :3] = colour
            else:
                self._model.tendon_width[tendon], self._model.tendon_rgba[tendon, :3] = width, colour

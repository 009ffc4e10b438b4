"""How a muscle looks: as thick as its law says at its length, and the brighter the more it pulls."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import names
from contarm_sim.mjcf.backbone import links
from contarm_sim.mjcf.nose import drawn_length
from contarm_sim.model.arm import Arm
from contarm_sim.view.rendering.braid import NAME, braid, repeats
from contarm_sim.view.rendering.tubes import Tube, add_picture, ended, hidden, smooth
from contarm_sim.view.sections import muscle_colours

SLACK = np.array([0.55, 0.55, 0.57])
"""Colour of a muscle without tension."""

_RINGS, _SIDES = 90, 16
"""Rings along a muscle, about, and sides around it."""


def tint(share: Array, colours: Array) -> Array:
    """Return colours, shape (M, 3), of muscles with shares of the largest tension, shape (M,); `colours`: at full."""
    return SLACK + (0.45 + 0.55 * np.clip(share, 0.0, 1.0))[:, None] * (colours - SLACK)


def radii(arm: Arm, lengths: Array) -> Array:
    """Return the radii of all muscles [m] at their lengths [m], shape (M,)."""
    each = [group for group in arm.groups for _ in range(group.routing.count)]
    found = [group.law.diameter_at(own, group.rest_length) for group, own in zip(each, lengths, strict=True)]
    return 0.5 * np.array(found)


class Muscles:
    """The muscles of a model that is drawn: braided tubes where they run parallel, else spatial tendons.

    Args:
        spec: the scene, not compiled yet; what it draws of muscles by itself is hidden.
    """

    def __init__(self, spec: Any, arm: Arm) -> None:
        import mujoco

        self._arm, self._colours = arm, muscle_colours(arm)
        self._end, self._heights = drawn_length(arm), np.array([link.height for link in links(arm)])
        self._tubes: dict[int, Tube] = {}
        self._spans: list[tuple[int, int]] = []
        self._points: list[Array] = []
        self._pieces: dict[int, int] = {}
        stations, starts = names.stations(arm), names.section_stations(arm)
        add_picture(spec, NAME, braid(), specular=0.25, shininess=0.3)
        for group in arm.groups:
            passed = stations[starts[group.first] : starts[group.section + 1] + 1]
            pieces = max(2, round(_RINGS / len(passed)))
            for point, muscle in zip(group.routing.points, names.group_muscles(arm, group), strict=True):
                self._spans.append((starts[group.first], starts[group.section + 1] + 1))
                self._points.append(np.array([*point, 0.0]))
                if group.routing.path != "parallel":
                    continue
                for station in passed:
                    hidden(spec.geom(names.guide(station, muscle)))
                look = spec.material(muscle)
                look.specular, look.shininess = 0.25, 0.3
                look.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = NAME
                i, rings = len(self._spans) - 1, pieces * (len(passed) - 1) + 1
                self._pieces[i] = pieces
                self._tubes[i] = Tube(
                    spec, muscle, names.BASE, rings, _SIDES, muscle, repeats(group.law, group.rest_length)
                )

    def compiled(self, model: Any, index: Any) -> None:
        """Find the muscles in the compiled model; `index`: its `ArmIndex`."""
        muscles = names.muscles(self._arm)
        self._model, self._index = model, index
        for tube in self._tubes.values():
            tube.compiled(model)
        self._materials = {i: int(model.material(muscles[i]).id) for i in self._tubes}

    def look(self, share: Array, data: Any) -> None:
        """Set thickness by the lengths in the engine's data, and colours by shares of the largest tension."""
        index, model = self._index, self._model
        self._radii = radii(self._arm, index.zero + data.ten_length[index.tendons])
        for i, colour in enumerate(tint(share, self._colours)):
            if i in self._tubes:
                model.mat_rgba[self._materials[i], :3] = colour
            else:
                model.tendon_width[index.tendons[i]] = self._radii[i]
                model.tendon_rgba[index.tendons[i], :3] = colour

    def place(self, scene: Any, data: Any) -> None:
        """Put the tubes where the engine's data have the links; after the engine has filled the scene."""
        stations = self._index.stations
        centres, turns = data.xpos[stations], data.xmat[stations].reshape(-1, 3, 3)
        for i, tube in self._tubes.items():
            along = slice(*self._spans[i])
            guides = centres[along] + turns[along] @ self._points[i]
            points, frames = smooth(guides, turns[along], self._pieces[i])
            heights = self._heights[along]
            rings = np.interp(np.linspace(0, len(heights) - 1, len(points)), np.arange(len(heights)), heights)
            tube.show(scene, ended(points, rings, self._end), frames, self._radii[i])

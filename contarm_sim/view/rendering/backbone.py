"""How the backbone looks: a smooth spine, and all disks of one colour in one mesh with rounded rims.

The engine's own cylinders and capsules have many times the triangles, which is what a frame's time goes to in software.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import names
from contarm_sim.mjcf.backbone import links
from contarm_sim.mjcf.nose import drawn_length
from contarm_sim.model.arm import Arm
from contarm_sim.view.rendering.overlays import Colour, add_disk
from contarm_sim.view.rendering.tubes import Tube, ended, hidden, smooth
from contarm_sim.view.sections import section_colour

_RINGS, _SIDES, _DISK_SIDES = 72, 12, 36
"""Rings along the spine, about, and sides of spine and disks."""

_ROUNDED = 0.5
"""Radius of a rim over the thickness of a disk."""

_PROFILE = ((0.0, 0.0, -1, -1.0), (1.0, -1.0, -1, -1.0), (1.0, 0.0, 0, 0.0), (1.0, -1.0, 1, 1.0), (0.0, 0.0, 1, 1.0))
"""Outline of a disk, each point: radius [radii], and in roundings; height [half thicknesses]; normal along the axis."""

_LIT = 1.06
"""Radius of a disk that glows, over its own."""

_PALER = 0.6
"""Share of a section's colour in that of its disks; the rest is white."""


class Backbone:
    """The spine, disks and plates of an arm; changes a spec that is not compiled yet."""

    def __init__(self, spec: Any, arm: Arm) -> None:
        stations = names.stations(arm)
        self._end, self._heights = drawn_length(arm), np.array([link.height for link in links(arm)])
        self._radii = np.array([hidden(spec.geom(f"{name}_spine"))[0] for name in stations])
        self._pieces = max(2, round(_RINGS / len(stations)))
        self._spine = Tube(
            spec, "spine", names.BASE, self._pieces * (len(stations) - 1) + 1, _SIDES, spec.geom("base_spine").material
        )
        found: dict[str, list[tuple[int, float, float, float]]] = {}
        for number, station in enumerate(stations):
            for part in ("disk", "guide"):
                geom = spec.geom(f"{station}_{part}")
                if geom is not None:
                    radius, half, _ = hidden(geom)
                    found.setdefault(geom.material, []).append((number, geom.pos[2], radius, half))
        self._disks = [(np.array(own), Tube(spec, f"{look}s", names.BASE, len(_PROFILE) * len(own), _DISK_SIDES, look))
                       for look, own in found.items()]  # fmt: skip

    def compiled(self, model: Any, index: Any) -> None:
        """Find the meshes in the compiled model; `index`: its `ArmIndex`."""
        self._stations = index.stations
        for tube in (self._spine, *(tube for _, tube in self._disks)):
            tube.compiled(model)

    def place(self, scene: Any, data: Any) -> None:
        """Put all where the engine's data have the links; after the engine has filled the scene."""
        centres, turns = data.xpos[self._stations], data.xmat[self._stations].reshape(-1, 3, 3)
        points, frames = smooth(centres, turns, self._pieces)
        along = np.linspace(0, len(centres) - 1, len(points))
        points = ended(points, np.interp(along, np.arange(len(centres)), self._heights), self._end)
        self._spine.show(scene, points, frames, np.interp(along, np.arange(len(centres)), self._radii))
        radial, rounding, height, axial = (np.array(part) for part in zip(*_PROFILE, strict=True))
        for own, tube in self._disks:
            number = own[:, 0].astype(int)
            radius, half = own[:, 2:3], own[:, 3:4]
            outline = radial * radius + rounding * 2 * _ROUNDED * half
            high = own[:, 1:2] + height * half
            middle = centres[number, None] + high[:, :, None] * turns[number, None, :, 2]
            frames = np.repeat(turns[number], len(_PROFILE), axis=0)
            tube.show(scene, middle.reshape(-1, 3), frames, outline.ravel(), np.tile(axial, len(own)))

    def light(self, scene: Any, data: Any, stations: NDArray[np.intp], colour: Colour) -> None:
        """Let the disks of some stations glow, counted from the base."""
        for own, _ in self._disks:
            for number, high, radius, half in own:
                if number in stations:
                    body = self._stations.start + int(number)
                    turn = data.xmat[body].reshape(3, 3)
                    add_disk(
                        scene, data.xpos[body] + high * turn[:, 2], turn, _LIT * radius, half + 0.02 * radius, colour
                    )


def disk_colour(number: int) -> Array:
    """Return red, green and blue of the disks of a section, numbered from 0: its colour, lighter."""
    return _PALER * np.array(section_colour(number)) + (1 - _PALER)


def tell_sections_apart(spec: Any, arm: Arm) -> None:
    """Give the disks of each section a colour of their own where there are several; before a `Backbone` is made."""
    if len(arm.sections) == 1:
        return
    stations, starts = names.stations(arm), names.section_stations(arm)
    for number in range(len(arm.sections)):
        look = f"{names.of_section(arm, number)}disk"
        spec.add_material(name=look, rgba=[*disk_colour(number), 1.0], specular=0.3, shininess=0.4)
        for station in stations[starts[number] + 1 : starts[number + 1] + 1]:
            for part in ("disk", "guide"):
                geom = spec.geom(f"{station}_{part}")
                if geom is not None:
                    geom.material = look

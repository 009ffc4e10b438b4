"""The analytic arcs beside the arm: a thin line, and a tube of glass where the two are apart."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.mjcf import names
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import ANALYTIC, rgb
from contarm_sim.view.rendering.overlays import Colour, add_line, add_ring
from contarm_sim.view.rendering.tubes import Canvas, Tube, add_picture, ring
from contarm_sim.view.sections import section_places, tube_radii

GHOST: Colour = (*rgb(ANALYTIC), 0.55)
"""Colour of the tube, and its opacity at its outline."""

_LINE: Colour = (*rgb(ANALYTIC), 1.0)
_CASING: Colour = (1.0, 1.0, 1.0, 0.65)

_CLEAR = 0.10
"""Opacity of the tube where it faces the camera, over that at its outline."""

_NEAR, _FAR = 0.005, 0.015
"""Distance [lengths] up to which there is no tube, and from which it has all its colour: half of it at 1 %."""

_WIDER, _CLOSER = 1.25, 1.3
"""Radius of the tube over that of the arm, and how far before the arc, in these radii, the line is drawn: over the arm.
"""

_RINGS, _SIDES, _PIXELS = 48, 24, 64


def fade(distance: Array) -> Array:
    """Return what share of its colour the tube has at distances between arc and arm [lengths]: smooth from 0 to 1."""
    share = np.clip((distance - _NEAR) / (_FAR - _NEAR), 0.0, 1.0)
    return np.asarray(share**2 * (3 - 2 * share))


class Ghost:
    """The analytic arcs of an arm: one tube a section; changes a spec that is not compiled yet."""

    def __init__(self, spec: Any, arm: Arm) -> None:
        self._arm, self._radii = arm, [_WIDER * inside for inside in tube_radii(arm)]
        clear = np.zeros((_PIXELS, _PIXELS, 4), np.uint8)
        clear[..., :3] = np.round(255 * np.array(GHOST[:3]))
        self._names = [f"analytic_{number + 1}" for number in range(len(arm.sections))]
        for name in self._names:
            add_picture(spec, name, clear, rgba=[1, 1, 1, 0.99], specular=0.0, emission=0.6)
        self._tubes = [Tube(spec, name, names.BASE, _RINGS + 1, _SIDES, name) for name in self._names]
        self._along = section_places(arm, _RINGS)
        self._texels = section_places(arm, _PIXELS - 1)

    def compiled(self, model: Any) -> None:
        """Find tubes and textures in the compiled model."""
        for tube in self._tubes:
            tube.compiled(model)
        self._canvases = [Canvas(model, name) for name in self._names]

    def hide(self, scene: Any) -> None:
        """Draw nothing."""
        for tube in self._tubes:
            tube.hide(scene)

    def show(self, renderer: Any, base: Any, bend: Array, stations: Array, pixel: float) -> None:
        """Draw the arcs of a bend [rad], shape (2 S,), beside an arm with stations of the base frame [m], shape (T, 3).

        Args:
            base: the engine's view of the base body.
            pixel: the width of one, in a picture of 720 rows.
        """
        scene, arm, turned = renderer.scene, self._arm, base.xmat.reshape(3, 3)
        eye = np.mean([camera.pos for camera in scene.camera], axis=0)
        everywhere = []
        for number, radius in enumerate(self._radii):
            points = base.xpos + shape.position(bend, arm, self._along[number]) @ turned.T
            frames = turned @ shape.rotation(bend, arm, self._along[number])
            self._tubes[number].show(scene, points, frames, radius)
            share = self._paint(number, base, bend, stations, eye)
            self._canvases[number].upload(renderer)
            last = number == len(self._radii) - 1
            strength = share[-1] if last else 1.0
            if strength > 0.02:
                add_ring(scene, points[-1], frames[-1], radius, 2.0 * pixel, (*GHOST[:3], 0.85 * strength))
            everywhere.append(points[::2])
        line = np.concatenate(everywhere)
        towards = _CLOSER * max(self._radii) * _unit(eye - line)
        add_line(scene, line + towards, 4.2 * pixel, _CASING, rank=2)
        add_line(scene, line + 1.02 * towards, 2.2 * pixel, _LINE, rank=3)

    def _paint(self, number: int, base: Any, bend: Array, stations: Array, eye: Array) -> Array:
        """Paint a tube: clear where it faces the camera and where arc and arm agree; return its shares of colour."""
        xi, turned = self._texels[number], base.xmat.reshape(3, 3)
        own = shape.position(bend, self._arm, xi)
        outward = ring(2 * np.pi * (np.arange(_PIXELS) + 0.5) / _PIXELS, turned @ shape.rotation(bend, self._arm, xi))
        view = eye - base.xpos - own @ turned.T
        view = view[:, None] - self._radii[number] * outward
        facing = np.sum(outward * view, axis=2) / np.linalg.norm(view, axis=2)
        rim = np.where(facing > -0.1, _CLEAR + (1 - _CLEAR) * (1 - np.clip(facing, 0, 1)) ** 3, 0.0)
        places = np.linspace(0, 1, len(stations)) if len(self._radii) == 1 else _places(self._arm)
        there = np.stack([np.interp(xi, places, stations[:, axis]) for axis in range(3)], axis=1)
        share = fade(np.linalg.norm(own - there, axis=1) / self._arm.length)
        alpha = 255 * GHOST[3] * rim * share[:, None]
        self._canvases[number].pixels[..., 3] = (alpha + 0.5).astype(np.uint8)
        return share


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _places(arm: Arm) -> Array:
    """Return the normalised arc lengths of an arm's stations."""
    steps = np.concatenate([np.full(section.links, section.length / section.links) for section in arm.sections])
    return np.concatenate([[0.0], np.cumsum(steps)]) / arm.length

"""The floor of a picture: even, with lines, and the soft shadow of the arm on it.

The engine's shadow map costs half of a frame in software and shows steps; a texture of Gaussian blobs costs nothing
that can be measured and is smooth.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf.scene import KEY, LINES, base_position, base_rotation, floor_colour, line_spacing, part_name
from contarm_sim.model.arm import Arm
from contarm_sim.view.rendering.casting import Casting
from contarm_sim.view.rendering.overlays import add_line
from contarm_sim.view.rendering.tubes import Canvas, add_picture

_NAME = "shadow"
_PIXELS = 128
_DARK = (38, 42, 56)
_DEEPEST = 0.62
"""Colour of the shadow, and its opacity where all light of the lamp is kept away."""

_SPREAD = 0.11
"""How far the lamp's light spreads: half-width of the edge of a shadow over the height of what casts it."""

_EDGE = 0.2
"""Share of half the shadow's square over which it fades towards the edge."""

_LINES, _PARTS = 6, 4
"""Where lines end, in their distances, and the parts of each: they fade away from the base."""


class Floor:
    """Floor, lines and shadow of an arm's picture; changes a spec that is not compiled yet."""

    def __init__(self, spec: Any, arm: Arm) -> None:
        import mujoco

        self._arm, self._base, self._casting = arm, base_position(arm), Casting(arm)
        slant = np.array(KEY[:2]) / -KEY[2]
        self._slant, self._size = slant, 1.6 * arm.length
        middle = base_position(arm)[2] + 0.5 * arm.length * base_rotation(arm)[2, 2]
        self._centre = slant * max(middle, 0.0) * 0.6
        for lamp in spec.lights:
            lamp.castshadow = False
        look = spec.material("floor")
        look.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = ""
        look.rgba = [*floor_colour(arm), 1.0]
        clear = np.zeros((_PIXELS, _PIXELS, 4), np.uint8)
        clear[..., :3] = _DARK
        add_picture(spec, _NAME, clear, rgba=[1, 1, 1, 0.99], specular=0.0, emission=1.0)
        spec.worldbody.add_geom(
            name=part_name(spec, _NAME), type=mujoco.mjtGeom.mjGEOM_PLANE, size=[self._size, self._size, 0.1],
            material=_NAME, pos=[*self._centre, 2e-3 * arm.length], contype=0, conaffinity=0,
        )  # fmt: skip

    def compiled(self, model: Any) -> None:
        """Find the texture in the compiled model."""
        self._canvas = Canvas(model, _NAME)
        across = np.linspace(-1, 1, _PIXELS)
        edge = np.clip((1 - np.abs(across)) / _EDGE, 0, 1)
        self._fade = np.outer(edge, edge)

    def shade(self, renderer: Any, stations: Array, payload: float, data: Any) -> None:
        """Paint the shadow of an arm with stations of the world [m], shape (T, 3), its payload's ball [m], and objects.

        Args:
            data: the engine's, where the objects are.
        """
        arm = self._arm
        radii = np.full(len(stations), arm.disk_radius)
        column = np.linspace([*stations[0][:2], 0.0], stations[0], 9)
        points, widths, spans = [stations], [radii], [_spans(stations)]
        if base_rotation(arm)[2, 2] > -0.1:
            points.append(column)
            widths.append(np.full(9, 0.55 * arm.disk_radius))
            spans.append(_spans(column))
        if payload:
            points.append(stations[-1:])
            widths.append(np.array([payload]))
            spans.append(np.array([1.5 * payload]))
        for centres, wide, long in self._casting.balls(data):
            points.append(centres)
            widths.append(wide)
            spans.append(long)
        alpha = shadow(
            np.vstack(points), np.concatenate(widths), np.concatenate(spans), self._slant,
            self._centre, self._size, _PIXELS,
        )  # fmt: skip
        self._canvas.pixels[..., 3] = (255 * _DEEPEST * self._fade * alpha + 0.5).astype(np.uint8)
        self._canvas.upload(renderer)

    def add_lines(self, scene: Any, width: float) -> None:
        """Draw the lines of the floor, so many pixels wide."""
        step, height = line_spacing(self._arm), 3e-3 * self._arm.length
        ends = step * _LINES * np.linspace(-1, 1, _PARTS + 1)
        for place in step * np.arange(1 - _LINES, _LINES):
            for start, end in pairwise(ends):
                far = np.hypot(place, 0.5 * (start + end)) / (step * _LINES)
                tint = (*LINES, 1 - min(far, 1.0) ** 2)
                if far < 1:
                    add_line(scene, np.array([[place, start, height], [place, end, height]]), width, tint)
                    add_line(scene, np.array([[start, place, height], [end, place, height]]), width, tint)


def shadow(points: Array, radii: Array, spans: Array, slant: Array, centre: Array, size: float, pixels: int) -> Array:
    """Return how much of a lamp's light balls keep from a square of floor, 0 to 1, shape (pixels, pixels).

    Each ball dims the light by a Gaussian, the wider the higher it is; what balls let pass is multiplied.

    Args:
        points: centres [m], shape (T, 3).
        radii: [m], shape (T,).
        spans: length that each ball stands for along the arm [m], shape (T,).
        slant: how far light goes to x and y by going down [-], shape (2,).
        centre, size: middle of the square and half its side [m].
        pixels: along a side; rows from the lowest y.
    """
    high = np.maximum(points[:, 2], 0.0)
    where = points[:, :2] + high[:, None] * slant
    width = np.sqrt((0.62 * radii) ** 2 + (_SPREAD * high) ** 2)
    area = 2 * radii * np.maximum(spans, 0.35 * radii)
    grid = size * (2 * (np.arange(pixels) + 0.5) / pixels - 1)
    x, y = (
        np.exp(-0.5 * ((grid + centre[axis] - where[:, axis, None]) / width[:, None]) ** 2) / width[:, None]
        for axis in (0, 1)
    )
    return np.asarray(1 - np.exp(-(y * (area / (2 * np.pi))[:, None]).T.astype(np.float32) @ x.astype(np.float32)))


def _spans(points: Array) -> Array:
    """Return the length of a line that each of its points stands for [m], shape (T,)."""
    steps = np.array([np.linalg.norm(end - start) for start, end in pairwise(points)])
    return 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))

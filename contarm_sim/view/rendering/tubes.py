"""Tubes whose shape is set anew for each picture: skins of the engine, written after it has placed them.

A skin is one mesh with a texture: smooth along the whole tube, where capsules show their joints, and drawn in one go.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array

UNSEEN = 5
"""Group of geoms that the engine's renderer leaves out."""


class Tube:
    """A tube of so many rings and sides in a spec. Texture: u once around it, v from 0 at its start to 1.

    Args:
        spec: what is compiled afterwards.
        body: name of a body to hang it on; any one does.
        material: its look.
        repeat: how often the texture is repeated around it, and along it.
    """

    def __init__(
        self, spec: Any, name: str, body: str, rings: int, sides: int, material: str,
        repeat: tuple[float, float] = (1.0, 1.0),
    ) -> None:  # fmt: skip
        self._name, self._turn = name, np.linspace(0.0, 2 * np.pi, sides + 1)
        first = (np.arange(rings - 1)[:, None] * (sides + 1) + np.arange(sides)).ravel()
        above = first + sides + 1
        around, along = np.meshgrid(repeat[0] * self._turn / (2 * np.pi), repeat[1] * np.linspace(0, 1, rings))
        count = rings * (sides + 1)
        skin = spec.add_skin(name=name, material=material)
        skin.vert = [0.0] * (3 * count)
        skin.texcoord = np.stack([around, along], axis=2).ravel().tolist()
        faces = np.stack([first, first + 1, above + 1, first, above + 1, above], axis=1)
        skin.face = faces.ravel().tolist()
        skin.bodyname, skin.bindpos, skin.bindquat = [body], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
        skin.vertid, skin.vertweight = [list(range(count))], [[1.0] * count]

    def compiled(self, model: Any) -> None:
        """Find the skin in the compiled model."""
        self._number = int(model.skin(self._name).id)

    def show(self, scene: Any, points: Array, frames: Array, radius: Any, axial: Array | None = None) -> None:
        """Put the tube along points of the world [m], shape (rings, 3), each with its frame, shape (rings, 3, 3).

        Args:
            radius: [m], one for all or shape (rings,).
            axial: part of the surface's normal along the axis, -1 to 1, shape (rings,); default none.
        """
        outward, place = ring(self._turn, frames), self._place(scene)
        radii = np.broadcast_to(radius, len(points))[:, None, None]
        scene.skinvert[place] = (points[:, None] + radii * outward).ravel()
        if axial is not None:
            sideways = np.sqrt(1 - axial**2)[:, None, None]
            outward = sideways * outward + axial[:, None, None] * frames[:, None, :, 2]
        scene.skinnormal[place] = outward.ravel()

    def hide(self, scene: Any) -> None:
        """Let all vertices be one point: nothing is drawn."""
        scene.skinvert[self._place(scene)] = 0.0

    def _place(self, scene: Any) -> slice:
        """Return where the vertices stand in the engine's arrays."""
        first = 3 * int(scene.skinvertadr[self._number])
        return slice(first, first + 3 * int(scene.skinvertnum[self._number]))


def hidden(geom: Any) -> Array:
    """Keep a geom of a spec from being drawn; return its sizes."""
    geom.rgba[3] = 0.0
    geom.group = UNSEEN
    return np.array(geom.size)


def ring(turn: Array, frames: Array) -> Array:
    """Return directions at angles [rad], shape (K,), about the z axes of frames, shape (T, 3, 3): shape (T, K, 3)."""
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    return np.asarray(circle @ np.swapaxes(frames, 1, 2))


def smooth(points: Array, frames: Array, pieces: int) -> tuple[Array, Array]:
    """Return a smooth curve through points, shape (T, 3), along the z axes of their frames, shape (T, 3, 3).

    From point to point a cubic whose inner controls are half a step along the axes: close to rigid links with a joint
    half-way. In so many pieces each; its frames are theirs, turned along.

    Returns:
        points, shape (K, 3), and frames, shape (K, 3, 3), of K = pieces (T - 1) + 1.
    """
    t = np.linspace(0, 1, pieces, endpoint=False)[:, None]
    start, end, one, other = points[:-1, None], points[1:, None], frames[:-1, None], frames[1:, None]
    size = 1.5 * np.linalg.norm(end - start, axis=2, keepdims=True)
    curve = (2 * t**3 - 3 * t**2 + 1) * start + (3 * t**2 - 2 * t**3) * end
    curve = curve + size * ((t**3 - 2 * t**2 + t) * one[..., 2] + (t**3 - t**2) * other[..., 2])
    turned = one + t[:, :, None] * (other - one)
    mixed = np.concatenate([turned.reshape(-1, 3, 3), frames[-1:]])
    return np.concatenate([curve.reshape(-1, 3), points[-1:]]), mixed / np.linalg.norm(mixed, axis=1, keepdims=True)


def ended(points: Array, along: Array, end: float) -> Array:
    """Return points, shape (..., K, 3), where those beyond an arc length are at it; `along`: theirs [m], shape (K,)."""
    if end >= along[-1]:
        return points
    last = int(np.searchsorted(along, end, "right")) - 1
    share = (end - along[last]) / (along[last + 1] - along[last])
    points = points.copy()
    points[..., last + 1 :, :] = (points[..., last, :] + share * (points[..., last + 1, :] - points[..., last, :]))[
        ..., None, :
    ]
    return points


def add_picture(spec: Any, name: str, pixels: NDArray[np.uint8], **look: Any) -> None:
    """Add a texture of pixels, shape (height, width, 3 or 4), and a material of the same name that shows it."""
    import mujoco

    height, width, channels = pixels.shape
    texture = spec.add_texture(
        name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=width, height=height, nchannel=channels
    )
    texture.data = pixels.tobytes()
    material = spec.add_material(name=name, **look)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name


class Canvas:
    """A texture that is painted anew for each picture."""

    def __init__(self, model: Any, name: str) -> None:
        self._model, self._id = model, int(model.texture(name).id)
        first = int(model.tex_adr[self._id])
        shape = (model.tex_height[self._id], model.tex_width[self._id], model.tex_nchannel[self._id])
        self.pixels = model.tex_data[first : first + int(np.prod(shape))].reshape(shape)

    def upload(self, renderer: Any) -> None:
        """Hand what is painted to the GL library of a `mujoco.Renderer`."""
        import mujoco

        renderer._gl_context.make_current()
        mujoco.mjr_uploadTexture(self._model, renderer._mjr_context, self._id)

"""Pictures of what stands in the scene without the scene: neither floor nor sky nor shadow, but opacity.

A picture on black, b, and the same one on white, w, differ by what shines through: opacity is 1 - (w - b), and
the colour is b over the opacity. Edges and glass come out as they are drawn on any background, but for rounding.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.view.rendering.tubes import UNSEEN

_KEPT = "mount"
"""Material of what holds the arm: it stays."""


def clear_away(model: Any) -> None:
    """Hide what surrounds the arm and its mount, and make the sky white; before a renderer is made of the model."""
    surroundings = (model.geom_bodyid == 0) & (model.geom_matid != model.material(_KEPT).id)
    model.geom_group[surroundings] = UNSEEN
    sky = model.texture("sky").id
    start = model.tex_adr[sky]
    size = model.tex_height[sky] * model.tex_width[sky] * model.tex_nchannel[sky]
    model.tex_data[start : start + size] = 255


def cut_out(renderer: Any) -> NDArray[np.uint8]:
    """Draw the scene of a renderer, whose model was cleared; return red, green, blue and opacity, shape (h, w, 4)."""
    from mujoco import mjtRndFlag as Flag

    flags = renderer.scene.flags
    for flag in (Flag.mjRND_SHADOW, Flag.mjRND_HAZE, Flag.mjRND_FOG, Flag.mjRND_REFLECTION):
        flags[flag] = 0
    pictures = []
    for white in (0, 1):
        flags[Flag.mjRND_SKYBOX] = white
        pictures.append(renderer.render())
    black, white = (picture.astype(np.float32) for picture in pictures)
    opacity = np.clip(255 - np.rint((white - black).mean(axis=2)), 0, 255)
    colour = 255 * black / np.maximum(opacity, 1)[..., None]
    return np.dstack([np.clip(np.rint(colour), 0, 255), opacity]).astype(np.uint8)

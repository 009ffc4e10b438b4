"""Where the picture is taken from: fixed cameras of the scene, one that circles it, one that follows the tip."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array

FIXED = ("front", "side", "top")
MOVING = ("orbit", "tip")
CAMERAS = FIXED + MOVING

_ELEVATION = 14.0
_AZIMUTH = 118.0
"""Of the moving cameras [deg]: the circle starts where `front` stands."""

_CLOSE = 0.9
"""Distance of the camera that follows the tip, in lengths of the arm."""


def check_camera(name: str) -> str:
    """Return a camera's name.

    Raises:
        InputError: there is no such camera.
    """
    if name not in CAMERAS:
        raise InputError("camera", repr(name), ", ".join(CAMERAS))
    return name


def eye(model: Any, name: str, tip: Array, share: float, length: float) -> Any:
    """Return what the engine's renderer takes for a camera: a name, or a free camera posed for this frame.

    Args:
        tip: of the drawn arm, in the world [m], shape (3,).
        share: of the film that has passed, 0 to 1: one turn of the circle.
        length: of the arm [m].
    """
    if name in FIXED:
        return name
    import mujoco

    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.elevation = -_ELEVATION
    if name == "orbit":
        front = model.cam_pos[model.camera("front").id]
        camera.lookat[:] = model.stat.center
        camera.distance = float(np.linalg.norm(front - model.stat.center))
        camera.azimuth = _AZIMUTH + 360.0 * share
    else:
        camera.lookat[:] = tip
        camera.distance = _CLOSE * length
        camera.azimuth = _AZIMUTH
    return camera

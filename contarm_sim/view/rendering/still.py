"""One picture of an arm in a pose."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.view.rendering.draw import ArmRenderer
from contarm_sim.view.rendering.near import with_objects


def still(arm: Arm, bend: Array, path: Path, width: int = 1280, height: int = 720, camera: str = "front") -> None:
    """Write a picture (.png) of the arm, every joint of a section bent alike; `bend` [rad], shape (2 S,)."""
    from PIL import Image

    seen = with_objects(shape.position(bend, arm, np.linspace(0, 1, 25)), arm)
    with ArmRenderer(arm, width, height, camera, seen) as renderer:
        Image.fromarray(renderer.pose(renderer.bent(bend))).save(path, optimize=True)

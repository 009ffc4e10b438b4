"""Where the tips of other arms are at the same moment: what an uncertain arm may be.

Their backbones are not drawn: they are so near to each other that they would be one thick tube over the muscles.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import SIMULATED, rgb
from contarm_sim.view.rendering.overlays import Colour, add_ball, placed
from contarm_sim.view.sections import tube_radii

NAME = "cloud.npz"
"""File of a run's folder that has such arms."""

TIP: Colour = (*rgb(SIMULATED), 1.0)

_CLOSER = 2.0
"""How far before the arm, in its radii, the tips are drawn: over it."""

_BALL = 0.007
"""Radius of a tip's ball [of the arm's length]."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """K other arms over T samples.

    Attributes:
        bones: places along their backbones [m], base frame, shape (K, T, P, 3).
        band: what tip errors of all such arms are between, and their median, as 5, 50 and 95 % [m], shape (3, T).
    """

    bones: NDArray[np.float32]
    band: Array

    def show(self, scene: Any, base: Any, index: int, arm: Arm) -> None:
        """Draw the tips of a sample; `base`: the engine's view of the base body."""
        eye = np.mean([camera.pos for camera in scene.camera], axis=0)
        for tip in placed(base, self.bones[:, index, -1].astype(float)):
            towards = (eye - tip) / np.linalg.norm(eye - tip)
            add_ball(scene, tip + _CLOSER * max(tube_radii(arm)) * towards, _BALL * arm.length, TIP)

    def save(self, folder: Path) -> None:
        """Write it into a run's folder."""
        np.savez_compressed(folder / NAME, bones=self.bones, band=self.band)

    @classmethod
    def load(cls, folder: Path, samples: int) -> Cloud | None:
        """Return what a run's folder has of it, or None.

        Raises:
            InputError: a damaged file, or one of another run.
        """
        if not (folder / NAME).is_file():
            return None
        try:
            with np.load(folder / NAME, allow_pickle=False) as file:
                bones, band = file["bones"], file["band"]
            fits = bones.ndim == 4 and bones.shape[1] == samples and band.shape == (3, samples)
        except (OSError, ValueError, KeyError, EOFError):
            fits = False
        if not fits:
            raise InputError(NAME, "damaged, or of another run", "what contarm run left", str(folder))
        return cls(bones, band)

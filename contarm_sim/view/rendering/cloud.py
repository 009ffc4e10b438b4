"""Other arms of the same moment, as thin lines over the one that is shown: what an uncertain arm may be."""

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
from contarm_sim.view.rendering.overlays import Colour, add_line, placed
from contarm_sim.view.sections import tube_radii

NAME = "cloud.npz"
"""File of a run's folder that has such arms."""

LINE: Colour = (*rgb(SIMULATED), 0.5)

_CLOSER = 1.35
"""How far before the arm, in its radii, the lines are drawn: over it."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """K other arms over T samples.

    Attributes:
        bones: places along their backbones [m], base frame, shape (K, T, P, 3).
        band: what tip errors of all such arms are between, and their median, as 5, 50 and 95 % [m], shape (3, T).
    """

    bones: NDArray[np.float32]
    band: Array

    def show(self, scene: Any, base: Any, index: int, arm: Arm, pixel: float) -> None:
        """Draw the backbones of a sample.

        Args:
            base: the engine's view of the base body.
            pixel: the width of one, in a picture of 720 rows.
        """
        eye = np.mean([camera.pos for camera in scene.camera], axis=0)
        for bone in self.bones[:, index].astype(float):
            points = placed(base, bone)
            towards = eye - points
            before = _CLOSER * max(tube_radii(arm)) * towards / np.linalg.norm(towards, axis=1, keepdims=True)
            add_line(scene, points + before, 1.1 * pixel, LINE, rank=2)

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

"""Many arms on a GPU: `Plants` on MuJoCo Warp, in single precision."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.engine.plants import Plants
from contarm_sim.engine.warp_batch import WarpBatch
from contarm_sim.engine.warp_library import library
from contarm_sim.engine.warp_models import kept_once
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array

_PROVEN = mujoco.mjtIntegrator.mjINT_IMPLICITFAST


class WarpPlants(Plants):
    """As `Plants`, on a CUDA device, or on the processor where there is none; not to the bits of one arm alone.

    Tips differ from those of `Plants` by some 1e-9 to 1e-6 of length, as single precision does; the same call on the
    same device gives the same numbers. Muscles must have the same places, and limits, in all arms. `qpos`, `qvel`,
    `pressure` and `state` are brought over from the device where they are asked for: ask again after a step.

    Args:
        integrator: `implicitfast`, the model's.
        threads, persistent: of no meaning here.
        (others): as of `Plants`.

    Raises:
        MissingError: MuJoCo Warp is not installed.
        InputError: another integrator, arms that can touch something, or what `Plants` refuses.
    """

    batch: WarpBatch
    engine = WarpBatch
    at_once = 1024

    def _begin(self, *given: Any) -> None:
        _check_integrator(self._integrator)
        for arm in given[0]:
            arm.refuse_objects("warp steps arms")
        super()._begin(*given)

    @staticmethod
    def check_installed() -> None:
        """Refuse to begin without MuJoCo Warp.

        Raises:
            MissingError: it is not installed.
        """
        library()

    @staticmethod
    def alike(plant: Plant) -> Any:
        """Return what MuJoCo Warp keeps once for all arms.

        Raises:
            InputError: another integrator.
        """
        _check_integrator(plant.integrator)
        return tuple(np.asarray(getattr(plant.model, name)).tobytes() for name in kept_once(plant.model))

    @property
    def rotations(self) -> Array:
        """Orientations of base plate, links and tip, shape (B, K, 3, 3)."""
        self.batch.refresh("xmat")
        return super().rotations

    @property
    def muscle_lengths(self) -> Array:
        """Muscle lengths [m], shape (B, M), as of `Plant`."""
        self.batch.pull()  # twist sees joint angles
        return super().muscle_lengths

    def stiffen_twist(self) -> None:
        """Let twisted parallel muscles stiffen the engine's joints by their present tensions: see `DrivenMuscles`."""
        if self._helices is None:
            return
        self.batch.pull()  # the helices see joint angles
        springs = np.stack([model.jnt_stiffness for model in self.models])
        springs[:, self.index.twisting] = self._untwisting + self._helices.joint_stiffness(self.muscle_tensions)
        self.batch.write("jnt_stiffness", springs)


def _check_integrator(integrator: mujoco.mjtIntegrator | None) -> None:
    """Refuse integrators that are not proven on this backend.

    Raises:
        InputError: says which is.
    """
    if integrator not in (None, _PROVEN):
        name = mujoco.mjtIntegrator(integrator).name.removeprefix("mjINT_").lower()
        allowed = "implicitfast on the backend warp: the only one shown to end there where the processor's engine does"
        raise InputError("integrator", name, allowed)

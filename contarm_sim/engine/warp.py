"""Many arms on a GPU: `Plants` on MuJoCo Warp, in single precision."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from contarm_sim.engine.models import Built, built
from contarm_sim.engine.plants import Plants
from contarm_sim.engine.warp_batch import WarpBatch
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import Actuation
from contarm_sim.model.arm import Arm

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
        InputError: another integrator, or what `Plants` refuses.
    """

    batch: WarpBatch
    engine = WarpBatch

    def __init__(
        self,
        arms: Sequence[Arm],
        actuation: Actuation = "lengths",
        pull_only: bool = True,
        timestep: float | ArrayLike | None = None,
        integrator: mujoco.mjtIntegrator | None = None,
        threads: int = 0,
        *,
        compiled: Callable[[Arm, Actuation], Built] = built,
        persistent: bool = False,
    ) -> None:
        check_integrator(integrator)
        super().__init__(arms, actuation, pull_only, timestep, integrator, threads, compiled=compiled)

    @property
    def rotations(self) -> Array:
        """Orientations of base plate, links and tip, shape (B, K, 3, 3)."""
        self.batch.refresh("xmat")
        return super().rotations

    def stiffen_twist(self) -> None:
        """Let twisted parallel muscles stiffen the engine's joints by their present tensions: see `DrivenMuscles`."""
        if self._helices is None:
            return
        self.batch.pull()  # the helices see joint angles
        springs = np.stack([model.jnt_stiffness for model in self.models])
        springs[:, self.index.twisting] = self._untwisting + self._helices.joint_stiffness(self.muscle_tensions)
        self.batch.write("jnt_stiffness", springs)


def check_integrator(integrator: mujoco.mjtIntegrator | None) -> None:
    """Refuse integrators that are not proven on this backend.

    Raises:
        InputError: says which is.
    """
    if integrator not in (None, _PROVEN):
        name = mujoco.mjtIntegrator(integrator).name.removeprefix("mjINT_").lower()
        allowed = "implicitfast on the backend warp: the only one shown to end there where the processor's engine does"
        raise InputError("integrator", name, allowed)

"""How the engine steps: how long a step is, and the longest that an arm can stand."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import TIMESTEP
from contarm_sim.mjcf.stability import SHORTEST, is_stable, unstable
from contarm_sim.model.host import Host
from contarm_sim.model.parameters import as_number


@dataclass(frozen=True)
class Stepping:
    """How the engine steps: time step [s], and integrator where it is not the model's own."""

    timestep: float = TIMESTEP
    integrator: mujoco.mjtIntegrator | None = None

    def __post_init__(self) -> None:
        if not SHORTEST <= as_number(self.timestep) <= 1.0:
            raise InputError("timestep", self.timestep, f"{SHORTEST:g} to 1 s")
        if self.integrator is not None:
            expect("integrator", self.integrator, mujoco.mjtIntegrator)

    def substeps(self, rate: float) -> int:
        """Return engine steps per control tick.

        Raises:
            InputError: the tick is no whole number of steps.
        """
        steps = 1 / (rate * self.timestep)
        if round(steps) < 1 or abs(steps - round(steps)) > 1e-6:
            raise InputError(
                "timestep", f"{self.timestep:g} s", f"a whole fraction of the control period, {1 / rate:g} s"
            )
        return round(steps)


ACCURATE = Stepping()
FAST = Stepping(0.01)


def stable_substeps(plant: Plant, rate: float, bends: Array, host: Host | None = None) -> int:
    """Return the least number of steps per control tick, at most `TIMESTEP` each, at which the arm cannot blow up.

    Args:
        plant: the arm alone.
        bends: uniform bends [rad], shape (B, 2 S), that are tried beside the straight pose.
        host: what the arm is in: steps are then at most its own.

    Raises:
        InputError: no step is stable; says what to change.
    """
    longest = TIMESTEP if host is None else min(TIMESTEP, host.read.timestep)
    count = math.ceil(1 / (rate * longest) - 1e-9)
    for bend in np.vstack([np.zeros((1, bends.shape[1])), bends]):
        plant.reset(bend)
        mujoco.mj_forward(plant.model, plant.data)
        while not is_stable(plant.model, plant.data, plant.arm, plant.actuation, 1 / (rate * count)):
            count *= 2
            if 1 / (rate * count) < SHORTEST:
                raise unstable(plant.arm)
    return count

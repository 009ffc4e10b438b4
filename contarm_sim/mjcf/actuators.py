"""What every actuation of the muscles has to say: one small class each, in a file of its own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import mujoco

from contarm_sim.mjcf.routing import Strands
from contarm_sim.model.muscle_group import MuscleGroup


class Actuators(ABC):
    """How the muscles are driven in the engine.

    Attributes:
        states: whether the engine integrates a state of each actuator, beginning at the control.
    """

    states = False

    @abstractmethod
    def add(self, spec: mujoco.MjSpec, strands: Sequence[Strands]) -> None:
        """Add the actuators of all muscles: one for each muscle, or several rounds of that, see `add_round`."""

    @abstractmethod
    def straight_control(self, group: MuscleGroup, share: float) -> float:
        """Return the control at which a muscle of the straight arm has so many times the least tension."""

    def stiffest(self, group: MuscleGroup) -> float:
        """Return the most that actuators let a muscle's tension gain by its length [N/m]."""
        return 0.0

    def damping(self, group: MuscleGroup) -> float:
        """Return the damping along each muscle [N s/m]."""
        return 0.0

    def write(self, model: mujoco.MjModel, muscles: Any, actuators: Any, group: MuscleGroup) -> None:
        """Write what depends on parameters that a kept model may change; see `engine.models`.

        Args:
            muscles: indices of the group's tendons.
            actuators: indices of its actuators.
        """
        return


def add_round(
    spec: mujoco.MjSpec, strands: Strands, default: mujoco.MjsDefault, ending: str = "", **given: Any
) -> None:
    """Add one actuator for each muscle, named after it."""
    for name in strands.names:
        spec.add_actuator(default, name=name + ending, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=name, **given)

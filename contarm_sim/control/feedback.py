"""Slow corrections of controls, by what is seen of the arm."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from contarm_sim.kinematics.arrays import Array

if TYPE_CHECKING:
    from contarm_sim.engine.plant import Plant


@dataclass(slots=True)
class Seen:
    """What a feedback sees. Lists and array change with the arm: copy what must last.

    Attributes:
        lengths: of the muscles [m], n numbers.
        speeds: their rates [m/s], lengthening > 0.
        tensions: of servos and of damping along the muscles [N], pulling > 0.
        pulls: of the servos alone [N], pulling > 0.
        tip: position [m], shape (3,).
    """

    lengths: list[float]
    speeds: list[float]
    tensions: list[float]
    pulls: list[float]
    tip: Array

    @classmethod
    def of(cls, plant: Plant) -> Seen:
        """Return what there is to see of a plant now."""
        lengths, tensions = plant.muscle_lengths.tolist(), plant.actuator_tensions.tolist()
        return cls(lengths, plant.data.ten_velocity.tolist(), tensions, plant.servo_pulls.tolist(), plant.centres[-1])


Memory = tuple[Array, ...]
"""What a feedback has summed up so far; assigned to another of its kind, that goes on from there."""


class Feedback(ABC):
    """Slow corrections of controls.

    `value` is added to the plan's controls. `update` is called once a control tick, with gain = tick / `time`; at rest
    with gain 1, until nothing changes. All that is summed up belongs into `memory`: a simulation takes it over from one
    feedback to another.

    Attributes:
        time: time constant [s].
        value: the present correction, shape (n,), in the controls' unit; changed in place.
    """

    def __init__(self, time: float, muscles: int) -> None:
        self.time = time
        self.value: Array = np.zeros(muscles)

    @abstractmethod
    def update(self, index: int, seen: Seen, gain: float) -> None:
        """Integrate one interval of sample `index`: change `value` in place."""

    @property
    def memory(self) -> Memory:
        """What has been summed up; override both if that is more than `value`."""
        return (self.value.copy(),)

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self.value[:] = memory[0]

"""Slow corrections of controls, by what is seen of the arm."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

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

    @classmethod
    def together(cls, each: Sequence[Self], ticks: Sequence[slice]) -> Feedback | None:
        """Return one that corrects the controls of B arms at once, from what these of single arms have summed up.

        To the same bits; None, as here, where there is no such: arms are then corrected one by one. Of what it is given
        and gives, `value` and all of `memory` have a leading axis of arms; `time`, gain and each number of a muscle
        seen are arrays, shape (B,), lists of these arrays of shape (n, B); `tip` has the shape (B, 3). A subclass does
        not inherit it.

        Args:
            each: the feedbacks, all of this very class.
            ticks: samples of each that it is to correct; `index` counts from the first of them.
        """
        return None

    @property
    def memory(self) -> Memory:
        """What has been summed up; override both if that is more than `value`."""
        return (self.value.copy(),)

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self.value[:] = memory[0]


def by_tick(arrays: Sequence[Any], ticks: Sequence[slice]) -> Array:
    """Return rows of arrays (T, ...) side by side, shape (most ticks, B, ...); the last goes on where there are fewer.

    Args:
        arrays: of each arm.
        ticks: of each arm.
    """
    parts = [np.asarray(array)[own] for array, own in zip(arrays, ticks, strict=True)]
    most = max(len(part) for part in parts)
    return np.stack([np.concatenate([part, np.repeat(part[-1:], most - len(part), axis=0)]) for part in parts], axis=1)


def applied(matrix: Array, vector: Array) -> Array:
    """Return matrices, shape (..., a, b), times vectors, shape (..., b): the same bits for one and for many."""
    return np.asarray((matrix @ vector[..., None])[..., 0])

"""What every task has: an episode that is drawn, what is seen of it, and how far off the arm is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from contarm_sim.envs.actions import Actions, Mode
from contarm_sim.envs.resting import Resting
from contarm_sim.envs.state import State
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.model.arm import Arm

CONTROL_PERIOD = 0.05
"""Time between actions [s]; controls are held in between."""

LIMIT = 10.0
"""Observations are clipped here; they are scaled so that random actions on the paper's arm stay within about 4."""

TOLERANCE = 0.01
"""Error that counts as none, as a fraction of length."""

NEAR = 0.05
"""Error that halves the shaped reward, as a fraction of length."""

Goals = dict[str, Array]
"""What an episode asks for: arrays of one episode, or stacked with a leading axis of arms."""


class Task(ABC):
    """A task for one arm: everything works on goals and states with a leading axis of arms, B.

    Attributes:
        arm: the arm that the task was made with; variations come on top.
        actions: what drives it; goals are those that it can hold.
        name: what it is called.
        time_limit: length of an episode [s]; it is cut off then.
        modes: the action modes that make sense, the default first.
        drawn: what an episode draws, by name, of an arm as it is; variations may replace it.
        half_turns: what changes of length reach to, in those of half a turn.
        aimless: whether there is no point to draw.
        touches: whether what the arm touches is what the task is about.
        over_time: whether success is judged by the root mean square of the error after `SETTLE`, not by the last one.
    """

    name: ClassVar[str]
    time_limit: ClassVar[float]
    modes: ClassVar[tuple[Mode, ...]]
    drawn: tuple[str, ...]
    half_turns: ClassVar[float] = 1.0
    aimless: ClassVar[bool] = False
    touches: ClassVar[bool] = False
    over_time: ClassVar[bool] = False

    def __init__(self, arm: Arm, mode: Mode) -> None:
        needed = self.needs(arm)
        if needed is not None:
            given = f"of {len(arm.sections)} sections and {muscles.count(arm)} muscles"
            raise InputError(f"arm for {self.name}", given, needed)
        self.arm, self.actions = arm, Actions(arm, mode, self.half_turns)

    @classmethod
    def needs(cls, arm: Arm) -> str | None:
        """Say what arm the task is for, if not for this one."""
        return None

    @classmethod
    def usual(cls) -> Arm:
        """Return the arm of a task that is asked for without one."""
        return Arm()

    @cached_property
    def resting(self) -> Resting:
        """Where the arm's tip rests under set-points of bends."""
        return Resting(self.actions)

    @abstractmethod
    def draw(self, random: np.random.RandomState) -> dict[str, Any]:
        """Draw an episode: values by the names in `drawn`."""

    @abstractmethod
    def prepare(self, values: dict[str, Any], arm: Arm) -> Goals:
        """Turn drawn values into goals, without an axis of arms.

        Args:
            arm: the arm of the episode, variations and all.

        Raises:
            InputError: a value, from a variation, that cannot be.
        """

    def staged(self, values: dict[str, Any], arm: Arm) -> Arm:
        """Return the arm of the episode among the objects that were drawn."""
        return arm

    @abstractmethod
    def quantities(self, goals: Goals, state: State, tick: Array) -> dict[str, Array]:
        """Return what the task lets be seen besides the arm's state, in SI units, each of shape (B, ...).

        Args:
            tick: control periods since the episodes began, shape (B,).
        """

    @property
    @abstractmethod
    def scales(self) -> dict[str, tuple[float, float]]:
        """(offset, scale) of every one of the `quantities`."""

    @abstractmethod
    def error(self, goals: Goals, state: State, tick: Array) -> Array:
        """Return how far off the arms are [m], shape (B,)."""

    def quality(self, goals: Goals, state: State) -> Array | float:
        """Return what the arms do besides being in place, shape (B,): 1 is all that is asked for, 0 nothing."""
        return 1.0

    def reward(self, goals: Goals, state: State, error: Array) -> Array:
        """Return the shaped reward, from 0 to 1, shape (B,)."""
        near = NEAR * self.arm.length
        return near / (near + error) * self.quality(goals, state)

    def solved(self, goals: Goals, state: State, error: Array) -> NDArray[np.bool_]:
        """Tell of which arms nothing more is asked for, shape (B,)."""
        return (error <= TOLERANCE * self.arm.length) & (self.quality(goals, state) >= 1.0)

    def follow(self, goals: Goals, state: State, stepped: NDArray[np.bool_]) -> None:  # noqa: B027  most remember nothing
        """Remember in the goals what the arms did that stepped, shape (B,)."""

    def lost(self, goals: Goals, state: State) -> NDArray[np.bool_] | None:
        """Tell which arms cannot solve the task any more, shape (B,), whose episodes end; None: all always can."""
        return None

    def force(self, goals: Goals) -> Array | None:
        """Return what pulls and turns the tip, base frame [N, N m], shape (B, 6), or None."""
        return None

    def target(self, goals: Goals, tick: int) -> Array | None:
        """Return the point to draw [m], shape (3,), of goals without an axis of arms."""
        return None


def norm(vector: Array) -> Array:
    """Return lengths, shape (B,), of vectors, shape (B, n): term by term, the same bits alone or among others."""
    total = vector[..., 0] * vector[..., 0]
    for i in range(1, vector.shape[-1]):
        total = total + vector[..., i] * vector[..., i]
    return np.sqrt(total)


def even_bend(random: np.random.RandomState, largest: float) -> Array:
    """Draw a bend [rad], shape (2,), evenly from the disk up to an angle."""
    angle, plane = largest * np.sqrt(random.random_sample()), 2 * np.pi * random.random_sample()
    return angle * np.array([np.cos(plane), np.sin(plane)])


def even_bends(random: np.random.RandomState, largest: float, count: int) -> Array:
    """Draw bends of several sections [rad], shape (2 S,), each evenly from the disk up to an angle."""
    return np.concatenate([even_bend(random, largest) for _ in range(count)])


def even_direction(random: np.random.RandomState) -> Array:
    """Draw a unit vector, shape (3,), evenly from the sphere."""
    z, plane = 2 * random.random_sample() - 1, 2 * np.pi * random.random_sample()
    flat = np.sqrt(1 - z * z)
    return np.array([flat * np.cos(plane), flat * np.sin(plane), z])

"""Episodes of some arms, side by side: drawn from each arm's own random state, seen, rewarded and ended together.

The front ends own the physics; this owns everything else, so that an arm's episode is the same bits wherever it runs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.envs import variations as variation
from contarm_sim.envs.definition import Definition
from contarm_sim.envs.state import State
from contarm_sim.envs.task import CONTROL_PERIOD, TOLERANCE, Goals
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

SETTLE = 1.0
"""Beginning of an episode that is not judged, where errors are judged over time [s]."""

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Outcome:
    """What one action led to, each of shape (B,).

    Attributes:
        reward: between 0 and 1.
        ended: whether the time is up, the arm has diverged, or its task is lost.
        lost: whether the task cannot be solved any more, as where an object has fallen.
        error: how far off each arm is [m].
        success: whether the task would count as solved, were this the end.
        diverged: whether the simulation of the arm blew up: it is rewarded nothing, and its error is not a number.
    """

    reward: Array
    ended: Flags
    lost: Flags
    error: Array
    success: Flags
    diverged: Flags

    @property
    def info(self) -> dict[str, NDArray[Any]]:
        """What the front ends pass on beside the reward."""
        return {"error": self.error, "success": self.success, "diverged": self.diverged}


class Episodes:
    """Episodes of `count` arms under one definition.

    Attributes:
        arms: the arm of each episode, variations and all.
        goals: what each episode asks for, stacked, (B, ...).
        tick: actions since each episode began, shape (B,).
        running: whether each episode has begun and not ended, shape (B,).
    """

    def __init__(self, definition: Definition, count: int) -> None:
        self.definition = definition
        self.arms = [definition.arm] * count
        self.goals: Goals = {}
        self.tick = np.zeros(count, dtype=int)
        self.running = np.zeros(count, dtype=bool)
        self._squares = np.zeros(count)

    def vary(self, index: int, random: np.random.RandomState) -> Arm:
        """Draw the arm of episode `index`; the first of two draws.

        Raises:
            InputError: a variation's value that an arm cannot have.
        """
        definition = self.definition
        self.arms[index] = variation.varied_arm(definition.variations, definition.arm, self.arms[index], random)
        return self.arms[index]

    def begin(self, index: int, random: np.random.RandomState) -> None:
        """Draw what episode `index` asks for and which objects are there, and begin it; the second of two draws.

        Raises:
            InputError: a variation's value that cannot be.
        """
        task, given = self.definition.task, self.definition.variations
        values = task.draw(random)
        for name in values:
            if name in given:
                values[name] = variation.evaluate(given[name], values[name], values[name], random)
        goals = task.prepare(values, self.arms[index])
        if not self.goals:
            self.goals = {name: np.zeros((len(self.arms), *value.shape)) for name, value in goals.items()}
        for name, value in goals.items():
            self.goals[name][index] = value
        self.arms[index] = task.staged(values, self.arms[index])
        self.tick[index], self._squares[index], self.running[index] = 0, 0.0, True

    def require_running(self, where: Flags | None = None) -> None:
        """Refuse a step without an episode.

        Raises:
            InputError: says whether it has not begun or has ended.
        """
        idle = ~self.running if where is None else where & ~self.running
        if idle.any():
            given = "after the end of its episode" if self.tick[idle].any() else "before any reset"
            raise InputError("step", given, "reset, then steps until the episode ends")

    def look(self, state: State) -> Outcome:
        """Judge the arms without counting an action: what a reset reports."""
        definition = self.definition
        task, goals = definition.task, self.goals
        error = task.error(goals, state, self.tick)
        good = task.solved(goals, state, error)
        reward = good.astype(float) if definition.reward == "sparse" else task.reward(goals, state, error)
        ended, none = self.tick >= definition.ticks, np.zeros(len(error), dtype=bool)
        return Outcome(reward, ended, none, error, self._successes(good), none)

    def advance(self, state: State, stepped: Flags | None = None, diverged: Flags | None = None) -> Outcome:
        """Count an action of the arms that stepped (default: all), and judge them; the others are rewarded nothing.

        Args:
            diverged: which of them the engine failed to simulate (default: none).
        """
        stepped = np.ones(len(self.arms), dtype=bool) if stepped is None else stepped
        self.tick += stepped
        self.definition.task.follow(self.goals, state, stepped)
        error = self.definition.task.error(self.goals, state, self.tick)
        self._squares += np.where(stepped & (self._judged > 0), error * error, 0.0)
        found = self.look(state)
        if diverged is not None and diverged.any():
            sound, error = ~diverged, np.where(diverged, np.nan, found.error)
            found = replace(
                found, reward=found.reward * sound, ended=found.ended | diverged, error=error,
                success=found.success & sound, diverged=diverged,
            )  # fmt: skip
        lost = self.definition.task.lost(self.goals, state)
        lost = found.lost if lost is None else lost & stepped & ~found.diverged
        ended = stepped & (found.ended | lost)
        self.running &= ~ended
        return replace(found, reward=np.where(stepped, found.reward, 0.0), ended=ended, lost=lost)

    @property
    def _judged(self) -> Array:
        """Actions that count where errors are judged over time, shape (B,)."""
        return self.tick - min(round(SETTLE / CONTROL_PERIOD), self.definition.ticks - 1)

    def _successes(self, good: Flags) -> Flags:
        if not self.definition.task.over_time:
            return good
        limit = TOLERANCE * self.definition.arm.length
        return (self._judged > 0) & (self._squares <= limit * limit * self._judged)

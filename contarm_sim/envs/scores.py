"""What policies reach over many seeds, an episode each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contarm_sim.envs.baseline import Policy, baseline, random_policy
from contarm_sim.envs.definition import Definition
from contarm_sim.envs.episodes import SETTLE
from contarm_sim.envs.task import CONTROL_PERIOD
from contarm_sim.envs.vector import ArmVectorEnv
from contarm_sim.kinematics.arrays import Array

POLICIES: dict[str, Callable[[Definition], Policy]] = {"baseline": baseline, "random": random_policy}
"""What `contarm envs` scores."""


@dataclass(frozen=True)
class Score:
    """One episode a seed, each of shape (seeds,).

    Attributes:
        reward: mean reward of an action.
        success: whether the task was solved.
        error: what success is judged by [m]: at the end, or the root mean square after the first second.

    An episode that was lost is rewarded nothing from there, and stays as it ended.
    """

    reward: Array
    success: Array
    error: Array

    @property
    def summary(self) -> dict[str, float]:
        """Plain numbers: mean reward, episodes solved, mean and largest error [m]."""
        return {
            "reward_mean": float(self.reward.mean()),
            "solved": int(self.success.sum()),
            "error_mean_m": float(self.error.mean()),
            "error_largest_m": float(self.error.max()),
        }


def score(
    definition: Definition, policy: Policy, seeds: int, on_step: Callable[[int, int], object] | None = None
) -> Score:
    """Run episodes of the seeds 0 .. seeds - 1 side by side.

    Args:
        on_step: called with (actions so far, actions in all), for progress.

    Raises:
        DivergenceError: the simulation of an arm blew up.
    """
    envs = ArmVectorEnv(
        seeds, task=definition.task.name, arm=definition.arm, actions=definition.actions.mode,
        reward=definition.reward, variations=definition.variations, time_limit=definition.ticks * CONTROL_PERIOD,
        contact=definition.contact,
    )  # fmt: skip
    observation, info = envs.reset(seed=0)
    rewards, errors = np.empty((2, definition.ticks, seeds))
    success, going = np.zeros(seeds, dtype=bool), np.ones(seeds, dtype=bool)
    for tick in range(definition.ticks):
        observation, reward, lost, _, info = envs.step(policy(observation))
        for error in envs.failed.values():
            raise error
        rewards[tick] = np.where(going, reward, 0.0)
        errors[tick] = np.where(going, info["error"], errors[tick - 1])
        success, going = np.where(going, info["success"], success), going & ~lost
        if on_step is not None:
            on_step(tick + 1, definition.ticks)
    envs.close()
    judged = errors[round(SETTLE / CONTROL_PERIOD) :] if definition.task.over_time else errors[-1:]
    return Score(rewards.mean(axis=0), success, np.sqrt((judged**2).mean(axis=0)))

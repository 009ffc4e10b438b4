"""Many arms for stable-baselines3: its `VecEnv`, on the native vector environment.

    from stable_baselines3 import PPO
    from contarm_sim.envs.sb3 import ArmVecEnv

    PPO("MlpPolicy", ArmVecEnv(32, task="reach")).learn(100_000)

An arm whose episode ends is reset in the same step, as stable-baselines3 has it: the step returns the first observation
of the next episode, and `infos` the last one of the old (`terminal_observation`). Episodes are cut off by time, so
`TimeLimit.truncated` is always true then. Needs the extra: pip install '.[train]'.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

from contarm_sim.errors import MissingError

if find_spec("stable_baselines3") is None:
    raise MissingError("stable-baselines3", "train")
if find_spec("gymnasium") is None:
    raise MissingError("gymnasium", "gym")

import numpy as np
from stable_baselines3.common.vec_env import VecEnv

from contarm_sim.envs.vector import ArmVectorEnv
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array


class ArmVecEnv(VecEnv):
    """Many arms under one task.

    Args:
        num_envs: arms.
        given: keywords of `ArmVectorEnv`.

    Attributes:
        arms: the `ArmVectorEnv`.

    Raises:
        InputError, RenderingError: as `ArmVectorEnv`.
    """

    def __init__(self, num_envs: int, **given: Any) -> None:
        self.arms = ArmVectorEnv(num_envs, **given)
        self._actions: Array = np.empty(0)
        super().__init__(self.arms.num_envs, self.arms.single_observation_space, self.arms.single_action_space)

    def reset(self) -> Array:
        """Begin an episode of every arm; seeds are those given to `seed`, once."""
        seeds = self._seeds if any(seed is not None for seed in self._seeds) else None
        observations, infos = self.arms.reset(seed=seeds)
        self.reset_infos = self._apart(infos)
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: Array) -> None:
        """Keep actions, shape (num_envs, size), for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Array, Array, Any, list[dict[str, Any]]]:
        """Apply the actions for one control period, and reset the arms whose episode has ended."""
        observations, rewards, lost, cut, infos = self.arms.step(self._actions)
        ended = lost | cut
        apart = self._apart(infos)
        for info in apart:
            info["TimeLimit.truncated"] = False
        if ended.any():
            last = observations
            observations, begun = self.arms.reset(options={"reset_mask": ended.copy()})
            fresh = self._apart(begun)
            for place in np.flatnonzero(ended).tolist():
                apart[place] |= {"terminal_observation": last[place].copy(), "TimeLimit.truncated": bool(cut[place])}
                self.reset_infos[place] = fresh[place]
        return observations, rewards.copy(), ended.copy(), apart

    def close(self) -> None:
        """Close the arms."""
        self.arms.close()

    def get_images(self) -> Sequence[Any]:
        """Return a picture of every arm, in render mode rgb_array."""
        return self.arms.render() or ()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute, the same for all arms, once for each."""
        return [getattr(self.arms, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: all arms share what they are.

        Raises:
            InputError: always.
        """
        raise InputError(attr_name, value, "what ArmVecEnv was made with: make another one")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Call a method of the vector once, and return its answer once for each arm."""
        found = getattr(self.arms, method_name)(*args, **kwargs)
        return [found for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Tell that no arm is wrapped."""
        return [False for _ in self._get_indices(indices)]

    def _apart(self, infos: dict[str, Any]) -> list[dict[str, Any]]:
        """Return a dict for each arm."""
        names = [name for name in infos if not name.startswith("_")]
        return [{name: infos[name][place].item() for name in names} for place in range(self.num_envs)]

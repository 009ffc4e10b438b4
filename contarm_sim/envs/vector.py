"""Many arms as one Gymnasium `VectorEnv`, stepped together on threads, see `engine.plants`.

The same bits as `gymnasium.vector.SyncVectorEnv` of as many `ArmEnv`, with any number of threads. Autoreset is its
default, NEXT_STEP: the step after an episode's end ignores that arm's action, resets it and rewards it nothing. An arm
that diverges ends its own episode, as `ArmEnv` says, and changes no bit of the others'.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from typing import Any

from contarm_sim.errors import MissingError

if find_spec("gymnasium") is None:
    raise MissingError("gymnasium", "gym")

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from contarm_sim import libmujoco
from contarm_sim.envs.actions import Mode
from contarm_sim.envs.arms import ArmLike
from contarm_sim.envs.definition import Reward, define
from contarm_sim.envs.episodes import Episodes, Flags, Outcome
from contarm_sim.envs.gym import ArmEnv, check_reset, spaces
from contarm_sim.envs.physics import Many
from contarm_sim.envs.picture import Picture, Sight, picture
from contarm_sim.envs.task import CONTROL_PERIOD
from contarm_sim.errors import DivergenceError, InputError
from contarm_sim.kinematics.arrays import Array

libmujoco.load()


class ArmVectorEnv(VectorEnv[Array, Array, Any]):
    """Many arms under one task; arm i of `reset(seed=s)` has the seed s + i.

    Args:
        num_envs: arms.
        threads: that step them; 0: one a processor.
        task, arm, actions, reward, variations, time_limit, gravity, payload, contact: as of `ArmEnv`. A variation that
            has a memory of its own is shared by all arms.
        render_mode: rgb_array or None.
        width, height, camera: of pictures, as of `ArmEnv`.
        max_episode_steps: Gymnasium's name of the time limit, in actions.

    Raises:
        InputError, RenderingError: as `ArmEnv`.
    """

    _picture: Picture | None = None  # here, for an older Gymnasium closes what was refused at construction

    metadata = {**ArmEnv.metadata, "render_modes": ["rgb_array"], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        threads: int = 0,
        task: str = "reach",
        arm: ArmLike | None = None,
        actions: Mode | None = None,
        reward: Reward = "shaped",
        variations: Mapping[str, Any] | None = None,
        time_limit: float | None = None,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        gravity: Any = None,
        payload: Any = None,
        width: int = 640,
        height: int = 480,
        camera: str = "front",
        contact: bool | None = None,
    ) -> None:
        for name, value, least in (("num_envs", num_envs, 1), ("threads", threads, 0)):
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
                raise InputError(name, value, f"a whole number, at least {least}")
        if render_mode is not None and not (isinstance(render_mode, str) and render_mode == "rgb_array"):
            raise InputError("render_mode", repr(render_mode), "rgb_array, None")
        if max_episode_steps is not None:
            if isinstance(max_episode_steps, bool) or not isinstance(max_episode_steps, (int, np.integer)):
                raise InputError("max_episode_steps", max_episode_steps, "a whole number, at least 1")
            time_limit = float(max_episode_steps * CONTROL_PERIOD) if abs(max_episode_steps) < 1e9 else np.inf
        self._sight = Sight(width, height, camera)
        self.definition = define(task, arm, actions, reward, variations, time_limit, gravity, payload, contact)
        self.num_envs, self.render_mode = int(num_envs), render_mode
        self.single_observation_space, self.single_action_space = spaces(self.definition)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._episodes = Episodes(self.definition, self.num_envs)
        self._physics = Many(self.definition, self.num_envs, int(threads))
        self._random: list[np.random.RandomState | None] = [None] * self.num_envs
        self._ended = np.zeros(self.num_envs, dtype=bool)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode of every arm, or of those in the option `reset_mask`, shape (num_envs,), bool."""
        self._require_open()
        check_reset(None, options)
        if seed is None or isinstance(seed, (int, np.integer)):
            check_reset(seed, None)
            super().reset(seed=None if seed is None else int(seed))
            seeds: Sequence[int | None] = [None if seed is None else int(seed) + i for i in range(self.num_envs)]
        else:
            seeds = list(seed) if isinstance(seed, (list, tuple, np.ndarray)) and np.ndim(seed) == 1 else []
        if len(seeds) != self.num_envs:
            given = f"{len(seeds)} seeds" if seeds else seed
            raise InputError("seed", given, f"one, or {self.num_envs}")
        for one in seeds:
            check_reset(one, None)
        mask = np.ones(self.num_envs, dtype=bool) if options is None else options.get("reset_mask")
        if mask is None:
            mask = np.ones(self.num_envs, dtype=bool)
        if not isinstance(mask, np.ndarray) or mask.shape != (self.num_envs,) or mask.dtype != bool or not mask.any():
            raise InputError("reset_mask", repr(mask), f"an array of {self.num_envs} bools, some of them true")
        if not mask.all() and any(random is None for random in self._random):
            raise InputError("reset_mask", "given before any reset", "reset all arms first")
        for place in np.flatnonzero(mask).tolist():
            if seeds[place] is not None:
                self._random[place] = np.random.RandomState(seeds[place])
            elif self._random[place] is None:
                self._random[place] = np.random.RandomState(self.np_random.integers(2**32))
        self._begin(mask)
        return self._observe(), self._info(self._episodes.look(self._physics.state), mask)

    def step(self, actions: Array) -> tuple[Array, Array, Flags, Flags, dict[str, Any]]:
        """Apply actions, shape (num_envs, size), for one control period."""
        self._require_open()
        checked = self.definition.actions.check(actions, self.num_envs)
        stepped, diverged = ~self._ended, None
        self._episodes.require_running(stepped)
        if stepped.all():
            diverged = self._physics.step(self.definition.actions.controls(checked), None)
        else:
            if stepped.any():
                diverged = self._physics.step(self.definition.actions.controls(checked), np.flatnonzero(stepped))
            self._begin(self._ended.copy())
        outcome = self._episodes.advance(self._physics.state, stepped, diverged)
        self._ended = outcome.ended.copy()
        info = self._info(outcome, np.ones(self.num_envs, dtype=bool))
        return self._observe(), outcome.reward, outcome.lost, outcome.ended & ~outcome.lost, info

    @property
    def failed(self) -> dict[int, DivergenceError]:
        """What was said of each arm whose simulation diverged, by its place, until it is reset."""
        return dict(self._physics.failed)

    def render(self) -> Any:
        """Return a picture of every arm, a tuple of arrays of shape (height, width, 3), in mode rgb_array."""
        if self.render_mode is None:
            return None
        if self._picture is None:
            self._picture = picture(self.render_mode, self.definition.arm, self._sight)
        drawn, positions = [], self._physics.positions
        for place in range(self.num_envs):
            goals = {name: value[place] for name, value in self._episodes.goals.items()}
            tick = int(self._episodes.tick[place])
            target = self.definition.task.target(goals, tick) if goals else None
            share, arm = tick / self.definition.ticks, self._episodes.arms[place]
            drawn.append(self._picture.draw(positions[place], target, share, arm))
        return tuple(drawn)

    def _require_open(self) -> None:
        if self.closed:
            raise InputError("step", "after close", "an environment that is open: make another one")

    def __reduce__(self) -> Any:
        raise TypeError(
            "an ArmVectorEnv cannot be pickled or copied: its arms live in the engine's threads; make another one with "
            "the same arguments, or use ArmEnv, which can be"
        )

    def close_extras(self, **kwargs: Any) -> None:
        """Close the renderer."""
        if self._picture is not None:
            self._picture.close()
            self._picture = None

    def _begin(self, mask: Flags) -> None:
        places = np.flatnonzero(mask)
        arms = {}
        for place in places.tolist():
            random = self._random[place]
            assert random is not None
            self._episodes.vary(place, random)
            self._episodes.begin(place, random)
            arms[place] = self._episodes.arms[place]
        self._physics.use(arms)
        self._physics.reset(places, self.definition.task.force(self._episodes.goals))
        self._ended[mask] = False

    def _observe(self) -> Array:
        quantities = self.definition.quantities(self._episodes.goals, self._physics.state, self._episodes.tick)
        return self.definition.flat(quantities)

    def _info(self, outcome: Outcome, mask: Flags) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for name, value in outcome.info.items():
            found[name], found[f"_{name}"] = np.where(mask, value, np.zeros_like(value)), mask.copy()
        return found

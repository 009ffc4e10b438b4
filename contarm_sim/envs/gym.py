"""The arm's tasks for Gymnasium: `contarm/Reach-v0`, `contarm/Track-v0`, `contarm/Hold-v0`, `contarm/Grasp-v0`.

Observations are flat, of float64; `state` and each task have tables of what they hold, in the order of
`Definition.sizes`. Actions are numbers in [-1, 1], see `actions`; what lies beyond is clipped. Episodes are truncated
at their time limit; terminated are those of `grasp` whose object is lost. `info` has `error` [m] and `success`; at the
end that is the verdict.

Where the simulation of an arm diverges, its episode is truncated there, rewarded nothing, and `info["diverged"]` is
true: no state of the task was reached. The error is NaN, and the last observation that of the straight arm at rest.

Importing this module registers them; so does a name with the module in front, which needs no import:
`gymnasium.make("contarm_sim.envs.gym:contarm/Reach-v0")`. Needs the extra: pip install '.[gym]'.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib.util import find_spec
from typing import Any

from contarm_sim.errors import MissingError

if find_spec("gymnasium") is None:
    raise MissingError("gymnasium", "gym")

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.spaces import Box

from contarm_sim import libmujoco
from contarm_sim.envs.actions import Mode
from contarm_sim.envs.arms import ArmLike
from contarm_sim.envs.definition import Definition, Reward, define
from contarm_sim.envs.episodes import Episodes
from contarm_sim.envs.physics import Single
from contarm_sim.envs.picture import RENDER_MODES, Picture, Sight, modes_here, picture
from contarm_sim.envs.registration import register
from contarm_sim.envs.task import CONTROL_PERIOD, LIMIT
from contarm_sim.errors import InputError, RenderingError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.rendering.window import has_display

libmujoco.load()
register()


def spaces(definition: Definition) -> tuple[Box, Box]:
    """Return the spaces of observations and of actions."""
    actions = definition.actions.size
    return Box(-LIMIT, LIMIT, (definition.size,), np.float64), Box(-1.0, 1.0, (actions,), np.float64)


class ArmEnv(gymnasium.Env[Array, Array]):
    """One arm and one task.

    Args:
        task: reach, track, hold or grasp.
        arm, actions, reward, variations, time_limit, gravity, payload, contact: see `definition.define`; `arm` may be
            an `Arm`, the name of a preset or the path of a TOML file.
        render_mode: rgb_array, human (needs a display) or None.
        width, height, camera: of pictures of mode rgb_array, see `picture.Sight`.

    An episode is drawn from a `np.random.RandomState` of the seed given to `reset`, as dm_control's is: the first
    episode after `reset(seed=s)` is that of `contarm_sim.envs.dm.load(..., random=s)`. Later resets without a seed go
    on from there.

    Raises:
        InputError: an unknown task, mode, variation or render mode; an arm that the task is not for; an action of
            another shape or not finite; a step before reset or after the end.
        RenderingError: nothing can be drawn here.
    """

    metadata = {"render_modes": list(RENDER_MODES), "render_fps": round(1 / CONTROL_PERIOD)}  # noqa: RUF012

    def __init__(
        self,
        task: str = "reach",
        arm: ArmLike | None = None,
        actions: Mode | None = None,
        reward: Reward = "shaped",
        variations: Mapping[str, Any] | None = None,
        time_limit: float | None = None,
        render_mode: str | None = None,
        gravity: Any = None,
        payload: Any = None,
        width: int = 640,
        height: int = 480,
        camera: str = "front",
        contact: bool | None = None,
    ) -> None:
        if render_mode is not None and not (isinstance(render_mode, str) and render_mode in RENDER_MODES):
            raise InputError("render_mode", repr(render_mode), ", ".join(RENDER_MODES) + ", None")
        if render_mode == "human" and not has_display():
            raise RenderingError("no window for render_mode human: there is no display here; rgb_array needs none")
        self._sight = Sight(width, height, camera)
        self.definition = define(task, arm, actions, reward, variations, time_limit, gravity, payload, contact)
        self.metadata = self.metadata | {"render_modes": modes_here()}  # Gymnasium's checker tries them all
        self.observation_space, self.action_space = spaces(self.definition)
        self.render_mode = render_mode
        self._episodes = Episodes(self.definition, 1)
        self._physics = Single(self.definition)
        self._random: np.random.RandomState | None = None
        self._spec: EnvSpec | None = None
        self._picture: Picture | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """What Gymnasium knows of the environment; it says how many steps an episode has."""
        return self._spec

    @spec.setter
    def spec(self, given: EnvSpec | None) -> None:
        self._spec = None if given is None else replace(given, max_episode_steps=self.definition.ticks)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_picture": None}  # a copy draws for itself

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin an episode: the arm straight and at rest."""
        check_reset(seed, options)
        super().reset(seed=seed)
        if seed is not None:
            self._random = np.random.RandomState(seed)
        elif self._random is None:
            self._random = np.random.RandomState(self.np_random.integers(2**32))
        self._episodes.vary(0, self._random)
        self._episodes.begin(0, self._random)
        self._physics.use(self._episodes.arms[0])
        self._physics.reset(self.definition.task.force(self._episodes.goals))
        state = self._physics.state
        if self.render_mode == "human":
            self._draw()
        return self._observe(), _first(self._episodes.look(state).info)

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Apply an action for one control period."""
        self._episodes.require_running()
        diverged = self._physics.step(self.definition.actions.controls(self.definition.actions.check(action)))
        outcome = self._episodes.advance(self._physics.state, diverged=diverged)
        if self.render_mode == "human":
            self._draw()
        lost = bool(outcome.lost[0])
        ends = lost, bool(outcome.ended[0]) and not lost
        return self._observe(), float(outcome.reward[0]), *ends, _first(outcome.info)

    def render(self) -> Any:
        """Return a picture, shape (height, width, 3), in mode rgb_array; the window of mode human follows by itself."""
        if self.render_mode is None:
            return None
        return self._draw()

    def close(self) -> None:
        """Close window or renderer."""
        if self._picture is not None:
            self._picture.close()
            self._picture = None

    def _observe(self) -> Array:
        episodes = self._episodes
        quantities = self.definition.quantities(episodes.goals, self._physics.state, episodes.tick)
        return self.definition.flat(quantities)[0]

    def _draw(self) -> Any:
        if self._picture is None:
            self._picture = picture(str(self.render_mode), self.definition.arm, self._sight)
        goals, tick = {name: value[0] for name, value in self._episodes.goals.items()}, int(self._episodes.tick[0])
        target = self.definition.task.target(goals, tick) if goals else None
        share, arm = tick / self.definition.ticks, self._episodes.arms[0]
        return self._picture.draw(self._physics.positions[0], target, share, arm)


def check_reset(seed: Any, options: Any) -> None:
    """Refuse what a reset cannot begin with.

    Raises:
        InputError: a seed that is no whole number from 0 to 2^32 - 1, or options that are no dict.
    """
    whole = isinstance(seed, (int, np.integer)) and not isinstance(seed, bool)
    if seed is not None and not (whole and 0 <= seed < 2**32):
        raise InputError("seed", seed, "a whole number from 0 to 4294967295, or None")
    if options is not None and not isinstance(options, Mapping):
        raise InputError("options", repr(options), "a dict, or None")


def _first(info: dict[str, Array]) -> dict[str, Any]:
    return {name: value[0].item() for name, value in info.items()}

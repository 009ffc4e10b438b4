"""The arm's tasks for dm_control: `contarm_sim.envs.dm.load("reach", random=0)`, as dm_control's suite loads its own.

Observations are dictionaries in SI units: those of the entity by its name (`contarm/tip_position`), those of the task
by theirs (`target`); rewards, actions, episodes and variations are those of the Gymnasium tasks, number by number. Time
runs out with discount 1, an object is lost with 0; a step before a reset, or after the last, resets, as dm_env has it.
`dm_control.viewer.launch` takes what `load` returns.

Needs dm-control, which cannot be installed on Python 3.13.
"""

from __future__ import annotations

import functools
import importlib.util
import sys
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

if importlib.util.find_spec("dm_control") is None:
    how = (
        "get it with: pip install dm-control==1.0.50" if sys.version_info < (3, 13) else "there is none for this Python"
    )
    raise ImportError(f"contarm_sim.envs.dm needs dm-control 1.0.50, for Python 3.11 and 3.12; {how}")

import dm_env
import numpy as np
from dm_env import specs

from contarm_sim.engine.plant import quiet_engine
from contarm_sim.envs.actions import Mode, action_names
from contarm_sim.envs.arms import ArmLike
from contarm_sim.envs.definition import TASKS, Definition, Reward, define
from contarm_sim.envs.dm_entity import ArmArena, ContinuumArm, PhysicsError, composer, observable
from contarm_sim.envs.episodes import Episodes, Outcome
from contarm_sim.envs.task import CONTROL_PERIOD
from contarm_sim.errors import DivergenceError
from contarm_sim.model.arm import Arm

ALL = tuple(TASKS)
"""Names that `load` takes."""

__all__ = ["ALL", "ArmEnvironment", "ArmTask", "ContinuumArm", "load"]


def load(
    name: str,
    random: int | np.random.RandomState | None = None,
    arm: ArmLike | None = None,
    actions: Mode | None = None,
    reward: Reward = "shaped",
    variations: Mapping[str, Any] | None = None,
    time_limit: float | None = None,
    gravity: Any = None,
    payload: Any = None,
    contact: bool | None = None,
) -> ArmEnvironment:
    """Return an environment by name.

    Args:
        name: reach, track, hold or grasp.
        random: a seed or a random state; the first episode is Gymnasium's after `reset(seed=random)`.
        arm, actions, reward, variations, time_limit, gravity, payload, contact: see `definition.define`; `arm` may be
            an `Arm`, the name of a preset or the path of a TOML file.

    Pictures are `env.physics.render(height, width, camera_id="front")`; other cameras are side and top.

    Raises:
        InputError: an unknown name, or a value that cannot be; by steps: an action of another shape or not finite.
    """
    definition = define(name, arm, actions, reward, variations, time_limit, gravity, payload, contact)
    return ArmEnvironment(
        ArmTask(definition),
        random_state=random,
        strip_singleton_obs_buffer_dim=True,
        recompile_mjcf_every_episode=definition.task.touches
        or bool(set(definition.variations) - set(definition.task.drawn)),
    )


class ArmEnvironment(composer.Environment):
    """A `composer.Environment` that says where it diverged, and logs no warnings of the engine.

    Raises:
        DivergenceError: the simulation blew up.
    """

    def step(self, action: Any) -> dm_env.TimeStep:
        """Apply an action for one control period."""
        with quiet_engine():
            try:
                return super().step(action)
            except PhysicsError as error:
                task, time = self.task.definition.task.name, float(self.physics.data.time)
                raise DivergenceError(time, -1, "?", {"task": task}) from error


class ArmTask(composer.Task):
    """One of the tasks as a `composer.Task`.

    Attributes:
        definition: the task, front ends aside.
        arm: the entity.
    """

    def __init__(self, definition: Definition) -> None:
        self.definition = definition
        self.arm = ContinuumArm(definition.arm, definition.actions, timestep=definition.timestep)
        self._arena = ArmArena(definition.arm)
        self._arena.place(self.arm)
        if not definition.arm.world.touchable:
            self._arena.mjcf_model.option.integrator = "implicitfast"
        self._aim(definition.arm)
        self.set_timesteps(CONTROL_PERIOD, definition.timestep)
        self._ball = self._arena.add_ball(definition.arm, visible=not definition.task.aimless)
        self._episodes = Episodes(definition, 1)
        self._outcome: Outcome | None = None
        for name, one in self.arm.observables.as_dict(fully_qualified=False).items():
            one.enabled = name in definition.sizes
        self._observables = OrderedDict()
        for name in definition.task.scales:
            self._observables[name] = observable.Generic(functools.partial(self._see, name))
            self._observables[name].enabled = True

    @property
    def root_entity(self) -> ArmArena:
        """The arena."""
        return self._arena

    @property
    def task_observables(self) -> OrderedDict[str, Any]:
        """What the task lets be seen, SI units, see its module."""
        return self._observables

    @property
    def info(self) -> dict[str, Any]:
        """The error [m] and the success of the last step, as Gymnasium's `info`; empty after a reset."""
        return {name: value[0].item() for name, value in self._outcome.info.items()} if self._outcome else {}

    def action_spec(self, physics: Any) -> specs.BoundedArray:
        """Return the spec of actions: numbers in [-1, 1]."""
        actions = self.definition.actions
        names = action_names(actions.arm, actions.mode)
        return specs.BoundedArray((actions.size,), float, -1.0, 1.0, "\t".join(names))

    def get_reward_spec(self) -> specs.BoundedArray:
        """Return the spec of rewards: between 0 and 1."""
        return specs.BoundedArray((), float, 0.0, 1.0, "reward")

    def initialize_episode_mjcf(self, random_state: np.random.RandomState) -> None:
        """Draw the arm of the episode, and the objects around it, which need a compilation too."""
        before = self._episodes.arms[0]
        self._episodes.vary(0, random_state)
        if self.definition.task.touches:
            self._episodes.begin(0, random_state)
        arm = self._episodes.arms[0]
        if arm != before:
            self.arm.vary(arm)
            self._arena.vary(arm)
            self._aim(arm)

    def initialize_episode(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Draw what is asked for, and put the arm straight and at rest."""
        if not self.definition.task.touches:
            self._episodes.begin(0, random_state)
        self._outcome = None
        self.arm.straighten(physics)
        force = self.definition.task.force(self._episodes.goals)
        if force is not None:
            parts = [self._arena.vector_to_world(part) for part in (force[0, :3], force[0, 3:])]
            physics.bind(self.arm.payload).xfrc_applied = np.concatenate(parts)
        self._show(physics)

    def before_step(self, physics: Any, action: Any, random_state: np.random.RandomState) -> None:
        """Apply an action."""
        self._episodes.require_running()
        self.arm.apply_action(physics, action, random_state)

    def after_step(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Judge the step."""
        self._outcome = self._episodes.advance(self.arm.state(physics))
        self._show(physics)

    def get_reward(self, physics: Any) -> float:
        """Return the reward of the last step."""
        return float(self._last.reward[0])

    def should_terminate_episode(self, physics: Any) -> bool:
        """Tell whether time is up or the task is lost."""
        return bool(self._last.ended[0])

    def get_discount(self, physics: Any) -> float:
        """Return 1, also where time is up, and 0 where the task is lost."""
        return 0.0 if self._outcome is not None and self._outcome.lost[0] else 1.0

    @property
    def _last(self) -> Outcome:
        assert self._outcome is not None
        return self._outcome

    def _see(self, name: str, physics: Any) -> Any:
        episodes, task = self._episodes, self.definition.task
        if not episodes.goals:  # specs are asked for before the first episode
            return np.zeros(self.definition.sizes[name])
        return task.quantities(episodes.goals, self.arm.state(physics), episodes.tick)[name][0].copy()

    def _aim(self, arm: Arm) -> None:
        self._arena.mjcf_model.option.gravity = self._arena.vector_to_world(arm.gravity)

    def _show(self, physics: Any) -> None:
        goals = {name: value[0] for name, value in self._episodes.goals.items()}
        target = self.definition.task.target(goals, int(self._episodes.tick[0]))
        if target is not None:
            physics.model.site_pos[physics.bind(self._ball).element_id] = self._arena.point_to_world(target)

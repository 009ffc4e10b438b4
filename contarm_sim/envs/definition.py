"""A task as people ask for it: an arm, what actions mean, how it is rewarded, what varies; its flat observations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import mujoco
import numpy as np

from contarm_sim.engine.models import Built, built
from contarm_sim.envs import variations as variation
from contarm_sim.envs.actions import Actions, Mode
from contarm_sim.envs.arms import ArmLike, as_arm
from contarm_sim.envs.hold import Hold
from contarm_sim.envs.reach import Reach
from contarm_sim.envs.state import State, add_end_sensors, scales
from contarm_sim.envs.state import sizes as sizes_of_state
from contarm_sim.envs.task import CONTROL_PERIOD, LIMIT, Goals, Task
from contarm_sim.envs.track import Track
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import Actuation, arm_spec
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number

TASKS: dict[str, type[Task]] = {kind.name: kind for kind in (Reach, Track, Hold)}

Reward = Literal["shaped", "sparse"]
REWARDS: tuple[Reward, ...] = get_args(Reward)

TOLERANCE = 0.01
"""Error that counts as none, as a fraction of length."""

NEAR = 0.05
"""Error that halves the shaped reward, as a fraction of length."""


@dataclass(frozen=True)
class Definition:
    """One task, ready to be simulated by any front end.

    Attributes:
        task: what is asked for.
        reward: shaped: NEAR / (NEAR + error), errors in lengths, times the task's `quality`; sparse: 1 within the
            tolerance (and of quality 1), else 0.
        variations: what changes from episode to episode.
        ticks: actions in an episode.
        timestep: of the engine [s], one that suits the arm without variations; all variations take the same.
        sizes: numbers of every observed quantity, by name, in the order of the flat observation.
        offset, scale: of the flat observation, (value - offset) / scale, each of shape (size,).
    """

    task: Task
    reward: Reward
    variations: dict[str, Any]
    ticks: int
    timestep: float = field(init=False)
    sizes: dict[str, int] = field(init=False)
    offset: Array = field(init=False, repr=False, compare=False)
    scale: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        arm, of_state = self.arm, sizes_of_state(self.arm)
        seen = [name for name in of_state if name != "pressures" or self.actions.mode == "pressures"]
        sizes = {name: of_state[name] for name in seen}
        odd = {"bend_asked": 2, "bend_error": 2, "stiffness_asked": 1, "stiffness": 1}
        known = scales(arm) | self.task.scales
        sizes |= {name: odd.get(name, 3) for name in self.task.scales}
        object.__setattr__(self, "sizes", sizes)
        object.__setattr__(self, "timestep", arm_spec(arm, self.actions.actuation).option.timestep)
        for place, what in enumerate(("offset", "scale")):
            value = np.concatenate([np.full(size, known[name][place]) for name, size in sizes.items()])
            object.__setattr__(self, what, value)

    @property
    def arm(self) -> Arm:
        """The arm without variations."""
        return self.task.arm

    @property
    def actions(self) -> Actions:
        """What actions mean."""
        return self.task.actions

    @property
    def substeps(self) -> int:
        """Engine steps in a control period."""
        return round(CONTROL_PERIOD / self.timestep)

    @property
    def size(self) -> int:
        """Numbers in a flat observation."""
        return sum(self.sizes.values())

    def built(self, arm: Arm) -> Built:
        """Return the model of an arm, the caller's own, without what is drawn: nothing touches it."""
        own = built(arm, self.actions.actuation, unseen_spec)
        own.model.opt.timestep = self.timestep
        return own

    def quantities(self, goals: Goals, state: State, tick: Array) -> dict[str, Array]:
        """Return all that is seen, in SI units, by the names of `sizes`, each of shape (B, size)."""
        return {**state, **self.task.quantities(goals, state, tick)}

    def flat(self, quantities: dict[str, Array]) -> Array:
        """Return flat observations, shape (B, size): scaled and clipped quantities in the order of `sizes`."""
        values = np.concatenate([quantities[name] for name in self.sizes], axis=-1)
        return ((values - self.offset) / self.scale).clip(-LIMIT, LIMIT)

    def unflat(self, observation: Array) -> dict[str, Array]:
        """Return the quantities [SI units] of flat observations, shape (..., size)."""
        values = self.offset + self.scale * observation
        ends = np.cumsum(list(self.sizes.values()))
        return dict(zip(self.sizes, np.split(values, ends[:-1], axis=-1), strict=True))


def plain_spec(arm: Arm, actuation: Actuation, timestep: float) -> mujoco.MjSpec:
    """Return the arm as the environments simulate it: `arm_spec` with the payload not drawn, and `add_end_sensors`.

    Whatever varies, models must be laid out alike. What tension in twisted muscles adds to `torsional_stiffness`, r^2
    times the sum of tensions, is in the model as a constant, that of the least tension in all muscles; `simulate` and
    `equilibrium` follow the tensions.
    """
    spec = arm_spec(arm, actuation, timestep)
    add_end_sensors(spec, arm)
    if arm.payload:
        spec.delete(spec.geom("payload"))
    return spec


def unseen_spec(arm: Arm, actuation: Actuation, timestep: float) -> mujoco.MjSpec:
    """Return `plain_spec` without what is drawn."""
    spec = plain_spec(arm, actuation, timestep)
    for geom in spec.geoms:
        spec.delete(geom)
    return spec


def define(
    name: str,
    arm: ArmLike | None = None,
    actions: Mode | None = None,
    reward: Reward = "shaped",
    variations: Mapping[str, Any] | None = None,
    time_limit: float | None = None,
    gravity: Any = None,
    payload: Any = None,
) -> Definition:
    """Return a task by name.

    Args:
        name: reach, track or hold.
        arm: an `Arm`, the name of a preset, or the path of a TOML file; default the paper's arm.
        actions: an action mode; default the task's own.
        reward: shaped or sparse.
        variations: what changes from episode to episode, see `variations`.
        time_limit: length of an episode [s], a multiple of the control period; default, and for `track` at most, the
            task's own.
        gravity, payload: in place of the arm's own, see `arms`.

    Raises:
        InputError: an unknown name, an arm that the task is not for, or a value that cannot be.
    """
    _check_name("task", name, tuple(TASKS))
    _check_name("reward", reward, REWARDS)
    modes = TASKS[name].modes
    if actions is not None:
        _check_name("actions", actions, modes, f" for {name}")
    task = TASKS[name](as_arm(arm, gravity, payload), actions or modes[0])
    limit = task.time_limit if time_limit is None else time_limit
    limit, given = as_number(limit), limit
    ticks = round(limit / CONTROL_PERIOD) if 0 < limit < 1e6 else 0
    longest = task.time_limit if task.over_time else np.inf
    if ticks < 1 or abs(ticks * CONTROL_PERIOD - limit) > 1e-9 or limit > longest:
        at_most = f", at most {longest:g} s" if np.isfinite(longest) else ""
        raise InputError("time_limit", given, f"a multiple of {CONTROL_PERIOD:g} s{at_most}")
    return Definition(task, reward, variation.check(variations, task.drawn, task.arm), ticks)


def _check_name(what: str, given: Any, known: tuple[str, ...], where: str = "") -> None:
    if not isinstance(given, str) or given not in known:
        raise InputError(what, repr(given) if isinstance(given, str) else given, ", ".join(known) + where)

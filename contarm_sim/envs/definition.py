"""A task as people ask for it: an arm, what actions mean, how it is rewarded, what varies; its flat observations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import mujoco
import numpy as np

from contarm_sim.engine.index import ArmIndex
from contarm_sim.engine.models import Built, built
from contarm_sim.envs import variations as variation
from contarm_sim.envs.actions import Actions, Mode
from contarm_sim.envs.arms import ArmLike, as_arm
from contarm_sim.envs.grasp import Grasp
from contarm_sim.envs.hold import Hold
from contarm_sim.envs.reach import Reach
from contarm_sim.envs.state import State, add_end_sensors, scales
from contarm_sim.envs.state import sizes as sizes_of_state
from contarm_sim.envs.task import CONTROL_PERIOD, LIMIT, Goals, Task
from contarm_sim.envs.touched import add_rate_sensors, touched_scales, touched_sizes
from contarm_sim.envs.track import Track
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import Actuation, arm_spec
from contarm_sim.mjcf.overlaps import refuse_overlaps
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number

TASKS: dict[str, type[Task]] = {kind.name: kind for kind in (Reach, Track, Hold, Grasp)}

Reward = Literal["shaped", "sparse"]
REWARDS: tuple[Reward, ...] = get_args(Reward)


@dataclass(frozen=True)
class Definition:
    """One task, ready to be simulated by any front end.

    Attributes:
        task: what is asked for.
        reward: shaped: NEAR / (NEAR + error), errors in lengths, times the task's `quality`; sparse: 1 within the
            tolerance (and of quality 1), else 0. `grasp` has its own, see there.
        variations: what changes from episode to episode.
        ticks: actions in an episode.
        contact: whether what the arm touches is seen, and free objects, see `touched`.
        timestep: of the engine [s], one that suits the arm without variations; all variations take the same.
        sizes: numbers of every observed quantity, by name, in the order of the flat observation.
        offset, scale: of the flat observation, (value - offset) / scale, each of shape (size,).
    """

    task: Task
    reward: Reward
    variations: dict[str, Any]
    ticks: int
    contact: bool = False
    timestep: float = field(init=False)
    sizes: dict[str, int] = field(init=False)
    offset: Array = field(init=False, repr=False, compare=False)
    scale: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        arm, of_state = self.arm, sizes_of_state(self.arm)
        seen = [name for name in of_state if name != "pressures" or self.actions.mode == "pressures"]
        sizes = {name: of_state[name] for name in seen} | (touched_sizes(arm) if self.contact else {})
        odd = {"bend_asked": 2, "bend_error": 2, "stiffness_asked": 1, "stiffness": 1, "rise": 1, "time": 1}
        known = scales(arm) | touched_scales(arm) | self.task.scales
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
        """Return the model of an arm, the caller's own, without what is only drawn.

        Raises:
            InputError: objects that the engine cannot make, or that are inside of the straight arm or one another.
        """
        if arm.world.touchable:
            model = unseen_spec(arm.without_memory, self.actions.actuation, self.timestep).compile()
            data = mujoco.MjData(model)
            mujoco.mj_resetDataKeyframe(model, data, 0)
            mujoco.mj_fwdPosition(model, data)
            refuse_overlaps(arm, model, data, "where the episode starts")
            return Built(model, ArmIndex.of(model, arm, in_world=True))
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
    add_rate_sensors(spec, arm)
    add_end_sensors(spec, arm)
    if arm.payload:
        spec.delete(spec.geom("payload"))
    return spec


def unseen_spec(arm: Arm, actuation: Actuation, timestep: float) -> mujoco.MjSpec:
    """Return `plain_spec` without what is only drawn."""
    spec = plain_spec(arm, actuation, timestep)
    for geom in spec.geoms:
        if not (arm.world.touchable and (geom.contype or geom.conaffinity)):
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
    contact: bool | None = None,
) -> Definition:
    """Return a task by name.

    Targets of `reach` keep clear of the objects of the arm's world, where these start; paths of `track` and bends of
    `hold` know nothing of them, and no task knows a host's bodies.

    Args:
        name: reach, track, hold or grasp.
        arm: an `Arm`, the name of a preset, or the path of a TOML file; default the paper's arm, of grasp `Grasp`'s.
        actions: an action mode; default the task's own.
        reward: shaped or sparse.
        variations: what changes from episode to episode, see `variations`.
        time_limit: length of an episode [s], a multiple of the control period; default, and for `track` at most, the
            task's own.
        gravity, payload: in place of the arm's own, see `arms`.
        contact: whether what the arm touches is seen, and free objects, see `touched`; default for grasp only.

    Raises:
        InputError: an unknown name, an arm that the task is not for, or a value that cannot be.
    """
    _check_name("task", name, tuple(TASKS))
    _check_name("reward", reward, REWARDS)
    modes = TASKS[name].modes
    if actions is not None:
        _check_name("actions", actions, modes, f" for {name}")
    kind = TASKS[name]
    task = kind(as_arm(kind.usual() if arm is None else arm, gravity, payload), actions or modes[0])
    seen = kind.touches if contact is None else contact
    if not isinstance(seen, bool) or (seen and not task.arm.world.touchable) or (kind.touches and not seen):
        allowed = "True" if kind.touches else "True for an arm whose world has objects, False"
        raise InputError("contact", contact, allowed)
    limit = task.time_limit if time_limit is None else time_limit
    limit, given = as_number(limit), limit
    ticks = round(limit / CONTROL_PERIOD) if 0 < limit < 1e6 else 0
    longest = task.time_limit if task.over_time else np.inf
    if ticks < 1 or abs(ticks * CONTROL_PERIOD - limit) > 1e-9 or limit > longest:
        at_most = f", at most {longest:g} s" if np.isfinite(longest) else ""
        raise InputError("time_limit", given, f"a multiple of {CONTROL_PERIOD:g} s{at_most}")
    return Definition(task, reward, variation.check(variations, task.drawn, task.arm), ticks, seen)


def _check_name(what: str, given: Any, known: tuple[str, ...], where: str = "") -> None:
    if not isinstance(given, str) or given not in known:
        raise InputError(what, repr(given) if isinstance(given, str) else given, ", ".join(known) + where)

"""Policies to compare a learner with: closed forms with feed-forward, and chance. Both take flat observations.

    reach  the bend whose tip is nearest to the target, in closed form; with gravity or payload the bend at whose
           set-points the model's own tip rests nearest to it (inverse statics)
    track  the same for where the target will be when the action has been carried out
    grasp  the script of the demonstration: curl up round the object, then bend what is nearer to the base; what has
           been gripped is kept up
    hold   tensions that balance bend, weight and wrench in closed form, co-contraction for the stiffness asked for, as
           pressures; what the measured bend lacks is added up in the same closed forms

Of several sections, bends are sought from those that the arm has, by damped least squares on the chain's closed form,
and followed from there as the target moves.

All of them know the arm that the task was made with, and nothing of variations.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contarm_sim.envs.definition import Definition
from contarm_sim.envs.hold import stiffness_at
from contarm_sim.envs.task import CONTROL_PERIOD
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.moments import wrench_moment
from contarm_sim.mechanics.pressures import level_range
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.statics import balance, holding_tensions

Policy = Callable[[Array], Array]
"""From flat observations, shape (B, size), to actions, shape (B, size of an action)."""

REMEMBERED = 10_000
"""Targets under load whose bends are kept."""

JUMP = 0.1
"""Way of a target between two actions that means another episode [lengths]: bends are sought anew."""

RELAX = 0.97
"""What bends are shortened by before they follow a target: of all that reach it, the arm goes to less bent ones."""

MARGIN = 1.02
"""Stiffness that the baseline of `hold` goes for, over what is asked for."""

GAIN, NEAR = 0.06, 0.15
"""Share of the measured bend's error that the baseline of `hold` makes up for in a control period, once the error is
below this [rad]: before, the arm is only on its way."""


def random_policy(definition: Definition, seed: int = 0) -> Policy:
    """Return a policy of even chance."""
    random = np.random.default_rng(seed)
    return lambda observation: random.uniform(-1.0, 1.0, (len(observation), definition.actions.size))


def baseline(definition: Definition) -> Policy:
    """Return the closed-form policy of a task. It has a memory: make a new one for new arms."""
    if definition.task.name == "hold":
        return _Hold(definition)
    if definition.task.name == "grasp":
        return _Grasp(definition)
    return _Steer(definition) if len(definition.arm.sections) == 1 else _SteerSections(definition)


class _Steer:
    """Bends the arm so that its tip meets a target."""

    def __init__(self, definition: Definition) -> None:
        self._definition, self._actions, self._arm = definition, definition.actions, definition.arm
        self._seen = "target" if definition.task.name == "reach" else "next"
        self._known: dict[bytes, Array] = {}

    def __call__(self, observation: Array) -> Array:
        seen = self._definition.unflat(observation)
        return self._asking(self._bends(seen[self._seen], seen))

    def _bends(self, targets: Array, seen: dict[str, Array]) -> Array:
        """Return the bends [rad], shape (B, 2 S), whose tips rest nearest to targets, under load each solved once."""
        resting = self._definition.task.resting
        if not resting.loaded:
            return resting.bends(targets)
        keys = [target.tobytes() for target in targets]
        new = [i for i, key in enumerate(keys) if key not in self._known]
        if len(self._known) + len(new) > REMEMBERED:
            self._known, new = {}, list(range(len(keys)))
        self._known |= {keys[i]: bend for i, bend in zip(new, resting.bends(targets[new]), strict=True)} if new else {}
        return np.array([self._known[key] for key in keys])

    def _asking(self, bend: Array) -> Array:
        """Return the actions that hold bends [rad], shape (B, 2 S)."""
        actions, mode = self._actions, self._actions.mode
        if mode == "bend":
            return actions.asking(bend)
        if mode == "lengths":
            return actions.asking(actions.setpoints(bend))
        if mode == "tensions":
            return actions.asking(holding_tensions(bend, self._arm))
        held = balance(bend, self._arm)
        level = level_range(held, self._arm)[0]
        return actions.asking(held.at(level) / np.maximum(held.per_pascal, 1e-9))


class _SteerSections(_Steer):
    """Bends the sections of an arm so that its tip meets a target, from one target to the next without a jump."""

    def __init__(self, definition: Definition) -> None:
        super().__init__(definition)
        self._targets: Array = np.empty((0, 3))
        self._last: Array = np.empty((0, 0))

    def _bends(self, targets: Array, seen: dict[str, Array]) -> Array:
        """Return the bends [rad], shape (B, 2 S); a target that has not moved keeps its own."""
        if len(targets) != len(self._targets):
            self._targets, self._last = (
                np.full(targets.shape, np.inf),
                np.zeros((len(targets), 2 * len(self._arm.sections))),
            )
        way = np.linalg.norm(targets - self._targets, axis=-1)
        new, moved = way > JUMP * self._arm.length, way > 0
        if new.any():
            self._last[new] = routing.bend_from_lengths(seen["muscle_lengths"][new], self._arm)[0]
        if moved.any():
            self._last[moved] = self._definition.task.resting.bends(targets[moved], RELAX * self._last[moved])
        self._targets = targets.copy()
        return self._last


class _Grasp:
    """Goes through the lengths of the demonstration, in time."""

    def __init__(self, definition: Definition) -> None:
        from contarm_sim.demos.grasp_script import LIFTED, LOWERING, controls_at

        arm, self._definition = definition.arm.alone, definition
        if len(arm.sections) != 2:
            raise InputError("arm for the baseline of grasp", f"of {len(arm.sections)} sections", "one of 2")
        time = np.arange(0.0, 0.5 * (LIFTED + LOWERING), CONTROL_PERIOD)
        self._actions = definition.actions.asking(controls_at(time, arm))

    def __call__(self, observation: Array) -> Array:
        time = self._definition.unflat(observation)["time"][:, 0]
        tick = np.round(time / CONTROL_PERIOD).astype(int) + 1
        return self._actions[np.minimum(tick, len(self._actions) - 1)]


class _Hold:
    """Balances a wrench and keeps a stiffness."""

    def __init__(self, definition: Definition) -> None:
        self._definition, self._arm = definition, definition.arm
        self._goals: Array = np.empty((0, 9))
        self._offset: Array = np.empty((0, 2))
        self._parts: list[tuple[Array, Array, Array]] = []

    def __call__(self, observation: Array) -> Array:
        seen = self._definition.unflat(observation)
        goals = np.concatenate([seen[name] for name in ("bend_asked", "force", "couple", "stiffness_asked")], axis=-1)
        if len(goals) != len(self._goals):
            self._goals, self._offset = np.full(goals.shape, np.nan), np.zeros((len(goals), 2))
            self._parts = [(np.empty(0),) * 3] * len(goals)
        for i in np.flatnonzero((goals != self._goals).any(axis=-1)).tolist():
            self._goals[i], self._offset[i], self._parts[i] = goals[i], 0.0, self._solve(goals[i])
        asked = np.empty((len(goals), 3))
        near = np.hypot(seen["bend_error"][:, 0], seen["bend_error"][:, 1]) < NEAR
        self._offset += GAIN * np.where(near[:, None], seen["bend_error"], 0.0)
        for i, (pressures, by_bend, by_level) in enumerate(self._parts):
            found = pressures + by_bend @ self._offset[i]
            lacking = (self._arm.pneumatics.min_pressure - found) / by_level
            asked[i] = found + max(float(lacking.max()), 0.0) * by_level
        return self._definition.actions.asking(asked)

    def _solve(self, goal: Array) -> tuple[Array, Array, Array]:
        """Return pressures [Pa], shape (3,), and their derivatives by the bend, (3, 2), and by the level, (3,)."""
        arm, bend, force, couple, stiffness = self._arm, goal[:2], goal[2:5], goal[5:8], float(goal[8])
        held = balance(bend, arm, load=wrench_moment(bend, force, couple, arm))
        lengths = routing.lengths_from_bend(bend, arm)
        J = length_jacobian(bend, arm)
        low, high = (float(level[0]) for level in level_range(held, arm))
        for _ in range(40):  # stiffness rises with the level
            middle = 0.5 * (low + high)
            enough = stiffness_at(held, middle, lengths, J, arm) >= MARGIN * stiffness
            low, high = (low, middle) if enough else (middle, high)
        spread = np.linalg.solve(J.T @ J, J.T)
        by_bend = -(spread.T * stiffness) / held.per_pascal[:, None]
        return held.at(np.array([high])) / held.per_pascal, by_bend, held.cocontraction[0] / held.per_pascal

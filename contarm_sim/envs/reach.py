"""`reach`: bring the tip to a point.

The point is where the tip rests at a bend drawn evenly from the disk to 170 deg: without load the dome, in closed form.
Under gravity or payload two degrees of freedom reach another surface, and points of the dome off it are out of every
controller's reach; there the point is the resting tip of the simulated arm under that bend's set-points.

    quantity   size  unit  scaled by
    target     3     m     L0
    to_target  3     m     L0
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.envs.actions import MAX_BEND, Actions, Mode
from contarm_sim.envs.state import State
from contarm_sim.envs.task import Goals, Task, even_bend, norm
from contarm_sim.errors import ConvergenceError, InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.simulation.plant import Plant, engine_room
from contarm_sim.simulation.solver import Solver

SHORTEN = 0.9
"""What a bend is shortened by where the loaded arm has no pose at rest."""


class Reach(Task):
    """Bring the tip to a point of the surface that it can rest on."""

    name: ClassVar[str] = "reach"
    time_limit: ClassVar[float] = 2.0
    modes: ClassVar[tuple[Mode, ...]] = ("bend", "lengths", "tensions", "pressures")
    drawn: ClassVar[tuple[str, ...]] = ("target",)

    def draw(self, random: np.random.RandomState) -> dict[str, Any]:
        """Draw a target [m]."""
        bend = even_bend(random, MAX_BEND)
        loaded = self.arm != self.arm.unloaded
        return {"target": self._resting.tip(bend) if loaded else arc.position(bend, self.arm.length)}

    @cached_property
    def _resting(self) -> RestingTip:
        return RestingTip(self.arm)

    def prepare(self, values: dict[str, Any], arm: Arm) -> Goals:
        """Check the target."""
        target = as_vectors(values["target"], 3, "target")
        if target.shape != (3,) or np.abs(target).max() > 2 * self.arm.length:
            raise InputError("target", target.tolist(), f"a point, 3 numbers within {2 * self.arm.length:g} m")
        return {"target": target}

    def quantities(self, goals: Goals, state: State, tick: Array) -> dict[str, Array]:
        """Show the target, and the way to it."""
        return {"target": goals["target"], "to_target": goals["target"] - state["tip_position"]}

    @property
    def scales(self) -> dict[str, tuple[float, float]]:
        """Lengths of the arm."""
        return {"target": (0.0, self.arm.length), "to_target": (0.0, self.arm.length)}

    def error(self, goals: Goals, state: State, tick: Array) -> Array:
        """Measure the distance from tip to target."""
        return norm(goals["target"] - state["tip_position"])

    def target(self, goals: Goals, tick: int) -> Array:
        """Draw the target."""
        return goals["target"]


class RestingTip:
    """Finds where the tip of a loaded arm rests under the set-points of a bend."""

    def __init__(self, arm: Arm) -> None:
        self._actions, self._plant = Actions(arm, "bend"), Plant(arm)
        self._settle = Solver(self._plant)

    def tip(self, bend: Array) -> Array:
        """Return the resting tip [m], shape (3,); a bend without a pose at rest is shortened until there is one.

        Raises:
            ConvergenceError: not even the straight pose is one.
        """
        for _ in range(100):
            try:
                with engine_room():
                    self._plant.reset(bend)
                    self._settle(self._actions.setpoints(bend[None])[0])
                return self._plant.tip
            except ConvergenceError as error:
                bend, failed = SHORTEN * bend, error
        raise failed

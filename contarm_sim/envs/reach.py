"""`reach`: bring the tip to a point.

The point is where the tip rests at a bend drawn evenly from the disk to 170 deg, shortened where the muscles could not
hold it (by pressures 131 deg in the worst plane): on the dome without load, on the surface that the arm reaches with
gravity or payload, see `resting`. Of several sections each is bent so, all shortened alike: the points fill the volume
that the tip can rest in.

Of an arm with objects, bends are drawn again until neither the arcs (but for what is next to the base) nor the tip
would touch an object where it starts; the way there may still be blocked. Targets know nothing of a host's bodies.

    quantity   size  unit  scaled by
    target     3     m     L0
    to_target  3     m     L0
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from contarm_sim.envs.actions import Mode
from contarm_sim.envs.state import State
from contarm_sim.envs.task import Goals, Task, even_bends, norm
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.model.arm import Arm

DRAWS = 1000
"""Bends that are drawn at most until one is clear of objects."""


class Reach(Task):
    """Bring the tip to a point that it can rest at."""

    name: ClassVar[str] = "reach"
    time_limit: ClassVar[float] = 2.0
    modes: ClassVar[tuple[Mode, ...]] = ("bend", "lengths", "tensions", "pressures")
    drawn = ("target",)

    def draw(self, random: np.random.RandomState) -> dict[str, Any]:
        """Draw a target [m] where no object is.

        Raises:
            InputError: objects that leave room for none.
        """
        for _ in range(DRAWS):
            bends = self.actions.within(even_bends(random, LARGEST_BEND, len(self.arm.sections))[None])
            target = self.resting.tips(bends)[0]
            if self._is_clear(bends, target):
                return {"target": target}
        names = ", ".join(each.name for each in self.arm.world.objects)
        raise InputError("objects", names, f"such as leave the arm room: it touches them in {DRAWS} poses of {DRAWS}")

    def _is_clear(self, bends: Array, target: Array) -> bool:
        """Tell whether the arm's arcs, bends of shape (1, 2 S), and its tip at the target touch no object."""
        world = self.arm.world
        if world.host is not None or not world.objects:
            return True
        from contarm_sim.planning.clearance import clearance_of

        clearance = clearance_of(self.arm)
        tube = clearance.tube
        away = tube.along > 2 * tube.radius[0]  # what the base stands on is always near
        places = np.vstack([tube.places(bends.reshape(1, -1, 2))[0, away], target])
        return bool((clearance.of_points(places)[0] > np.append(tube.radius[away], tube.radius[-1])).all())

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

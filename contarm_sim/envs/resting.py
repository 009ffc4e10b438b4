"""Where the tip rests under the set-points of a bend, and back: closed form without load, statics with it.

Under gravity or payload the tips that three lengths reach form another surface than the dome; targets are drawn from
it, for points of the dome off it are out of every controller's reach. Several sections reach a volume; without load
their tips are those of the chain of links, in closed form too.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from contarm_sim.control.tip_plan import TipPlan
from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.envs.actions import Actions, shortened
from contarm_sim.envs.aiming import nearest_bends
from contarm_sim.envs.state import bend_shown
from contarm_sim.errors import EquilibriumError, InputError
from contarm_sim.kinematics import arc, dome
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.statics.solver import Solver

CORRECTIONS = 8
"""Of a bend towards given set-points; each leaves about a hundredth of the error."""

SHORTEN = 0.9
"""What a bend is shortened by where the loaded arm has no pose at rest."""


class Resting:
    """Poses at rest of one arm under the set-points of the action mode `bend`.

    Args:
        actions: what drives the arm; of several sections, bends are sought that it can hold so.
    """

    def __init__(self, actions: Actions) -> None:
        self._arm, self._driven = actions.arm, actions
        self._actions = Actions(actions.arm, "bend")

    @property
    def loaded(self) -> bool:
        """Whether the arm has gravity or a payload to carry."""
        return self._arm != self._arm.unloaded

    @cached_property
    def _statics(self) -> tuple[Plant, Solver]:
        plant = Plant(self._arm)
        return plant, Solver(plant)

    @cached_property
    def _plan(self) -> TipPlan:
        return TipPlan(self._arm)

    def tips(self, bends: Array) -> Array:
        """Return the resting tips [m], shape (T, 3), of bends [rad], shape (T, 2 S).

        A bend without a pose at rest is shortened until it has one.

        Raises:
            EquilibriumError: not even the straight pose is one.
        """
        if not self.loaded:
            one = len(self._arm.sections) == 1
            return arc.position(bends, self._arm.length) if one else shape.chain_tip(bends, self._arm)
        with engine_room():
            return np.array([self._tip(bend) for bend in bends])

    def bends(self, targets: Array, near: Array | None = None) -> Array:
        """Return the bends [rad], shape (T, 2 S), to 170 deg whose tips rest nearest to targets [m], shape (T, 3).

        Where no pose at rest is found, those of the arm without load.

        Args:
            near: of several sections, bends about which solutions are sought [rad], shape (T, 2 S); default straight.
        """
        if len(self._arm.sections) > 1:
            near = np.zeros((len(targets), 2 * len(self._arm.sections))) if near is None else near
            bends = nearest_bends(targets, near, self._driven)
        else:
            bends = shortened(dome.bend_from_tip(targets, self._arm.length, "nearest").bend)
        if not self.loaded:
            return bends
        with engine_room():
            return np.array([self._bend(*pair) for pair in zip(bends, targets, strict=True)]).reshape(bends.shape)

    def _tip(self, bend: Array) -> Array:
        plant, settle = self._statics
        for _ in range(100):
            try:
                plant.reset(bend)
                settle(self._actions.setpoints(bend[None])[0])
                return plant.tip
            except EquilibriumError as error:
                bend, failed = SHORTEN * bend, error
        raise failed

    def _bend(self, bend: Array, target: Array) -> Array:
        try:
            self._plan.plant.reset(bend)
            setpoint, _ = self._plan.solve(bend, target)
        except (EquilibriumError, InputError):
            return bend
        for _ in range(CORRECTIONS):  # the bend whose own set-points have the same differences
            off = setpoint - self._actions.setpoints(bend[None])[0]
            bend = shortened(bend + bend_shown(off, self._arm))
        return np.asarray(bend)

"""Arms in the engine, for the front ends: `Single` has one, `Many` step many together on threads, to the same bits.

An arm that diverges is put straight and at rest, without a force on it: it has no other state that could be seen.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.divergence import any_fatal
from contarm_sim.engine.models import Built
from contarm_sim.engine.plants import Plants
from contarm_sim.engine.room import quiet_engine
from contarm_sim.envs.definition import Definition
from contarm_sim.envs.state import ENGINE_FIELDS, State, read
from contarm_sim.envs.touched import Columns
from contarm_sim.errors import DivergenceError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import Actuation
from contarm_sim.model.arm import Arm

Flags = NDArray[np.bool_]


class Single:
    """One arm, which can be copied and pickled.

    Attributes:
        data: the engine's.
    """

    def __init__(self, definition: Definition) -> None:
        self._definition, self._substeps = definition, definition.substeps
        self._arm: Arm | None = None
        self.use(definition.arm)

    def use(self, arm: Arm) -> None:
        """Take the parameters of an arm, unless it is the one in use; a reset must follow."""
        if arm == self._arm:
            return
        own = self._definition.built(arm)
        self._arm, self._model, self._tip = arm, own.model, own.index.payload
        self._columns = Columns.of(own.model, own.index, arm) if self._definition.contact else None
        self.data = mujoco.MjData(self._model)

    @property
    def state(self) -> State:
        """What is seen of the arm, B = 1; a copy."""
        own = {name: getattr(self.data, name)[None].copy() for name in ENGINE_FIELDS}
        return _seen(own, self._definition, self._columns)

    @property
    def positions(self) -> Array:
        """The engine's: joint angles [rad], then poses of free objects in the base frame, shape (1, nq); a view."""
        return np.asarray(self.data.qpos)[None]

    def reset(self, force: Array | None) -> None:
        """Put the arm straight and at rest, with a force [N, N m], shape (1, 6), on the tip."""
        mujoco.mj_resetDataKeyframe(self._model, self.data, 0)
        mujoco.mj_forward(self._model, self.data)
        if force is not None:
            self.data.xfrc_applied[self._tip] = force[0]  # whose centre of mass is the tip

    def step(self, controls: Array) -> Flags:
        """Hold controls, shape (1, nu), for one control period; return whether the arm diverged, shape (1,)."""
        model, data = self._model, self.data
        data.ctrl[:] = controls[0]
        with quiet_engine():
            # Positions and velocities are up to date, from the reset or from the last line: half a step is done.
            mujoco.mj_step2(model, data)
            mujoco.mj_step(model, data, self._substeps - 1)
            mujoco.mj_step1(model, data)
        diverged = any_fatal(data.warning.number)
        if diverged:
            self.reset(None)
        return np.array([diverged])


class Many:
    """Arms stepped together: `Plants` of the environments' models.

    Attributes:
        plants: the arms.
        failed: what was said of each arm that diverged, by its place, until it is reset.
    """

    def __init__(self, definition: Definition, count: int, threads: int) -> None:
        self._definition, self.failed = definition, dict[int, DivergenceError]()
        first = definition.built(definition.arm)  # one model for all arms that do not vary

        def compiled(arm: Arm, _: Actuation) -> Built:
            return first if arm == definition.arm else definition.built(arm)

        arms, actuation = [definition.arm] * count, definition.actions.actuation
        self.plants = Plants(
            arms, actuation, timestep=definition.timestep, threads=threads, compiled=compiled, persistent=True
        )
        batch = self.plants.batch
        self._fields = {name: batch.bind(name) for name in ENGINE_FIELDS}
        index = self.plants.index
        self._columns = Columns.of(first.model, index, definition.arm) if definition.contact else None
        self._controls = batch.bind("ctrl")
        self._forces = batch.bind("xfrc_applied")[:, index.payload]

    def use(self, arms: dict[int, Arm]) -> None:
        """Take the parameters of arms, by place; a reset of these must follow."""
        self.plants.become(arms)

    @property
    def state(self) -> State:
        """What is seen of the arms; views into the engine's arrays, which the next call changes."""
        return _seen(self._fields, self._definition, self._columns)

    @property
    def positions(self) -> Array:
        """As of `Single`, shape (B, nq)."""
        return np.asarray(self._fields["qpos"])

    def reset(self, places: NDArray[np.integer], forces: Array | None) -> None:
        """Put the arms at these places straight and at rest, with forces [N, N m], shape (B, 6), on their tips."""
        self._straighten(places)
        if forces is not None:
            self._forces[places] = forces[places]
        for place in places.tolist():
            self.failed.pop(place, None)

    def step(self, controls: Array, places: NDArray[np.integer] | None) -> Flags:
        """Hold controls, shape (B, nu), of the arms at these places (None: all) for one control period.

        Returns:
            which arms diverged, shape (B,).
        """
        if places is None:
            self._controls[:] = controls
        else:
            self._controls[places] = controls[places]
        with quiet_engine():
            self.plants.step(self._definition.substeps, places, mujoco.mjtStage.mjSTAGE_VEL)
        diverged = np.zeros(len(self.plants), dtype=bool)
        if self.plants.failed:
            self.failed |= self.plants.failed
            places = np.array(sorted(self.plants.failed))
            diverged[places] = True
            self._straighten(places)
        return diverged

    def _straighten(self, places: NDArray[np.integer]) -> None:
        self.plants.reset(places)
        self.plants.forward(places)


def _seen(source: dict[str, Array], definition: Definition, columns: Columns | None) -> State:
    state = read(source, definition.arm)
    return state if columns is None else state | columns.read(source["sensordata"], definition.arm)

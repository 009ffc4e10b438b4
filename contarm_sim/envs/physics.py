"""Arms in the engine, for the front ends: `Single` steps one, `Many` a batch of them on threads, to the same bits."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from contarm_sim.engine.plant import FATAL, quiet_engine
from contarm_sim.envs.definition import Definition
from contarm_sim.envs.state import ENGINE_FIELDS, State, read
from contarm_sim.errors import DivergenceError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm


class Single:
    """One arm.

    Attributes:
        data: the engine's.
    """

    def __init__(self, definition: Definition) -> None:
        self._definition, self._substeps = definition, definition.substeps
        self._arm: Arm | None = None
        self.use(definition.arm)

    def use(self, arm: Arm) -> None:
        """Compile the arm, unless it is the one in use; a reset must follow."""
        if arm == self._arm:
            return
        self._arm, self._model = arm, self._definition.model(arm)
        self.data = mujoco.MjData(self._model)
        self._tip = self._model.body("payload").id

    @property
    def state(self) -> State:
        """What is seen of the arm, B = 1; a copy."""
        return read({name: getattr(self.data, name)[None].copy() for name in ENGINE_FIELDS}, self._definition.arm)

    def reset(self, force: Array | None) -> None:
        """Put the arm straight and at rest, with a force [N, N m], shape (1, 6), on the tip."""
        mujoco.mj_resetDataKeyframe(self._model, self.data, 0)
        mujoco.mj_forward(self._model, self.data)
        if force is not None:
            self.data.xfrc_applied[self._tip] = force[0]  # whose centre of mass is the tip

    def step(self, controls: Array) -> None:
        """Hold controls, shape (1, nu), for one control period.

        Raises:
            DivergenceError: the engine met a bad state.
        """
        model, data = self._model, self.data
        data.ctrl[:] = controls[0]
        with quiet_engine():
            # Positions and velocities are up to date, from the reset or from the last line: half a step is done.
            mujoco.mj_step2(model, data)
            mujoco.mj_step(model, data, self._substeps - 1)
            mujoco.mj_step1(model, data)
        refuse_divergence(self._definition, data.warning.number, data.warning.lastinfo, model, data.time)


class Many:
    """A batch of arms on threads."""

    def __init__(self, definition: Definition, count: int, threads: int) -> None:
        self._definition, self._substeps = definition, definition.substeps
        model = definition.model(definition.arm)
        self._models = [model] * count
        self._arms = [definition.arm] * count
        self.batch = Batch(model, count, threads, persistent=True)
        self._fields = {name: self.batch.bind(name) for name in ENGINE_FIELDS}
        self._controls, self._forces = self.batch.bind("ctrl"), self.batch.bind("xfrc_applied")
        self._tip = model.body("payload").id

    def use(self, arms: dict[int, Arm]) -> None:
        """Compile arms, by place, that are not those in use; a reset of these must follow."""
        changed = {place: arm for place, arm in arms.items() if arm != self._arms[place]}
        for place, arm in changed.items():
            self._arms[place], self._models[place] = arm, self._definition.model(arm)
        if changed:
            self.batch.set_models(self._models)

    @property
    def state(self) -> State:
        """What is seen of the arms; views into the engine's arrays, which the next call changes."""
        return read(self._fields, self._definition.arm)

    def reset(self, places: NDArray[np.integer], forces: Array | None) -> None:
        """Put the arms at these places straight and at rest, with forces [N, N m], shape (B, 6), on their tips."""
        self.batch.reset(places, keyframe=0)
        if forces is not None:
            self._forces[places, self._tip] = forces[places]

    def step(self, controls: Array, places: NDArray[np.integer] | None) -> None:
        """Hold controls, shape (B, nu), of the arms at these places (None: all) for one control period.

        Raises:
            DivergenceError: the engine met a bad state.
        """
        if places is None:
            self._controls[:] = controls
        else:
            self._controls[places] = controls[places]
        with quiet_engine():
            self.batch.step(places, self._substeps, int(mujoco.mjtStage.mjSTAGE_VEL))
        for place in np.flatnonzero(self.batch.warning.any(axis=(1, 2))).tolist():
            where, count = self.batch.warning[place].T  # the engine's mjWarningStat: lastinfo, number
            refuse_divergence(self._definition, count, where, self._models[place], float(self.batch.time[place]), place)


def refuse_divergence(
    definition: Definition, warnings: Array, where: Array, model: Any, time: float, place: int | None = None
) -> None:
    """Raise if warning counters, and what each was last about, shape (7,), tell of a bad state.

    Raises:
        DivergenceError: names the task and, of many, the place of the arm.
    """
    if not warnings[FATAL].any():
        return
    dof = int(where[FATAL][np.argmax(warnings[FATAL] > 0)])
    joint = model.joint(model.dof_jntid[dof]).name if 0 <= dof < model.nv else "?"
    settings = {"task": definition.task.name, "actions": definition.actions.mode, "timestep": model.opt.timestep}
    raise DivergenceError(time, dof, joint, settings | ({} if place is None else {"arm number": place}))

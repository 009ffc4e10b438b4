"""MuJoCo Warp behind what `Plants` asks of `mujoco.batch.Batch`: models and states of many arms on a GPU.

Single precision, and on this machine's processor where no CUDA device is found: the same numbers, slowly. The device
keeps the states; the host has copies, brought over where they are asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.warp_device import WarpDevice
from contarm_sim.engine.warp_library import library
from contarm_sim.engine.warp_limits import ForceLimits
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array

_S = mujoco.mjtState
_STATE = int(_S.mjSTATE_INTEGRATION)
_MOVES = {"qpos": _S.mjSTATE_QPOS, "qvel": _S.mjSTATE_QVEL, "act": _S.mjSTATE_ACT}
"""Parts of a state that steps change."""

_SELDOM = ("xmat",)
"""Derived fields that are brought over by `refresh` alone."""

_HUGE = float(mujoco.mjMAXVAL)
_BAD = int(mujoco.mjtWarning.mjWARN_BADQPOS)


class WarpBatch:
    """States of `nsim` arms on a device, and their models; of `mujoco.batch.Batch` what `Plants` calls.

    Args:
        model: gives the sizes.
        nsim: how many.
        nthread, persistent: of no meaning here.

    Attributes:
        warning: as of `Batch`, shape (nsim, warnings, 2): joint angles that are not finite are found after a step.
        time: of each arm [s], shape (nsim,).
    """

    _device: WarpDevice

    def __init__(self, model: mujoco.MjModel, nsim: int, nthread: int = 0, persistent: bool = False) -> None:
        self._mjw = library()[1]
        self.nsim, self.time = nsim, np.zeros(nsim)
        self.warning = np.zeros((nsim, int(mujoco.mjtWarning.mjNWARNING), 2), dtype=np.int32)
        self._model, self._rows = model, np.zeros((nsim, mujoco.mj_stateSize(model, _STATE)))
        self._derived: dict[str, Array] = {}
        self._given: list[mujoco.MjModel] = [model] * nsim
        self._new_models, self._written, self._old = True, True, False
        self._gone = np.zeros(nsim, dtype=bool)

    def _columns(self, part: mujoco.mjtState) -> slice:
        before = _STATE & (int(part) - 1)
        first = mujoco.mj_stateSize(self._model, before)
        return slice(first, first + mujoco.mj_stateSize(self._model, int(part)))

    @property
    def state(self) -> Array:
        """All that arms go on from, as of `mjSTATE_INTEGRATION`, to read and to write, shape (nsim, size).

        Ask again after a step: the rows are then brought over anew.
        """
        self.pull()
        self._written = True
        return self._rows

    def bind(self, name: str) -> Array:
        """Return an array of a field of the engine's data, float64, shape (nsim, ...).

        Controls and derived fields stay current. Positions, rates and pressures are those of the last `pull`; they may
        be written: ask for them anew.
        """
        if name in _MOVES:
            return self.state[:, self._columns(_MOVES[name])]
        if name == "ctrl":
            return self._rows[:, self._columns(_S.mjSTATE_CTRL)]
        if name not in self._derived:
            shape = np.shape(getattr(mujoco.MjData(self._model), name))
            self._derived[name] = np.zeros((self.nsim, *shape))
        return self._derived[name]

    def set_models(self, models: Sequence[mujoco.MjModel]) -> None:
        """Take the parameters of these models, one an arm, from the next call on.

        Raises:
            InputError: at that call: they differ in what MuJoCo Warp keeps once for all arms.
        """
        self._given, self._new_models = list(models), True

    def write(self, name: str, values: Array) -> None:
        """Write a field of the models of all arms on the device, shape (nsim, ...)."""
        self._push()
        self._device.write(name, values)

    def reset(self, ids: Any = None, keyframe: int = -1, stage: int = 0) -> None:
        """Put arms at the models' defaults, or at a keyframe; nothing is derived."""
        at = np.arange(self.nsim) if ids is None else np.asarray(ids)
        self.pull()
        self._rows[at], self.time[at], self.warning[at], self._gone[at] = 0.0, 0.0, 0, False
        for place in at.tolist():
            model, row = self._given[place], self._rows[place]
            row[self._columns(_S.mjSTATE_QPOS)] = model.qpos0 if keyframe < 0 else model.key_qpos[keyframe]
            if keyframe >= 0:
                row[self._columns(_S.mjSTATE_ACT)] = model.key_act[keyframe]
                row[self._columns(_S.mjSTATE_CTRL)] = model.key_ctrl[keyframe]
        self._written = True

    def forward(self, ids: Any = None, stage: int = 0) -> None:
        """Derive everything of the present states."""
        self._run("forward", lambda: self._mjw.forward(self._device.model, self._device.data), ids)

    def step(self, ids: Any = None, nstep: int = 1, stage: int = 0) -> None:
        """Take `nstep` engine steps; derived fields are of the state before the last.

        Raises:
            InputError: more is asked to be derived afterwards.
        """
        if stage != int(mujoco.mjtStage.mjSTAGE_NONE):
            raise InputError("stage", stage, "mjSTAGE_NONE on the backend warp: call forward")

        self._run("step", lambda: self._mjw.step(self._device.model, self._device.data), ids, nstep)
        self._went_on(ids, nstep)

    def roll(self, controls: Array) -> None:
        """Step all arms through controls that are known beforehand, shape (steps, nsim, nu), in one go."""
        self._push()
        device, count = self._device, len(controls)
        sent = device.buffer(("sent", count), (count, *device.data.ctrl.shape))
        device.send(sent, controls)

        def steps() -> None:
            for k in range(count):
                device.copy(device.data.ctrl, sent[k])
                self._mjw.step(device.model, device.data)

        device.launch(("roll", count), steps)
        self._rows[:, self._columns(_S.mjSTATE_CTRL)] = controls[-1]
        self._fetch(None)
        self._went_on(None, count)

    def refresh(self, name: str) -> Array:
        """Bring a derived field over now and return it."""
        mirror = self.bind(name)
        mirror[:] = self._device.read(name).reshape(mirror.shape)
        return mirror

    def pull(self) -> None:
        """Bring the states over from the device, if they are newer there."""
        if not self._old:
            return
        moved = slice(0, self._columns(_S.mjSTATE_CTRL).start)  # the rest is the host's to say
        self._rows[:, moved] = self._device.states("pulled").numpy()[:, moved]
        self._rows[:, 0] = self.time
        self._old = False

    def _push(self) -> None:
        """Bring models, controls, and states where they were written, to the device."""
        if self._new_models:
            if not hasattr(self, "_device") or not self._device.take(self._given):
                self.pull()
                self._device, self._written = WarpDevice(self._given, self._rows.shape), True
            self._new_models = False
            self._limits = ForceLimits(self._given)
            self._steps = np.array([model.opt.timestep for model in self._given])
        self._rows[self._gone, self._columns(_S.mjSTATE_CTRL)] = 0.0
        if self._written:
            self._device.go_on_from(self._rows)
            self.time[:] = self._rows[:, 0]
            self._written = False
        else:
            self._device.send(self._device.data.ctrl, self._rows[:, self._columns(_S.mjSTATE_CTRL)])

    def _run(self, name: Any, work: Callable[[], object], ids: Any, times: int = 1) -> None:
        """Do something several times with arms `ids`, which the device does with all of them."""
        self._push()
        stay = ~self._gone
        stay[slice(None) if ids is None else np.asarray(ids)] = False
        if stay.any():
            before = self._device.states("before")
        for _ in range(times):
            self._device.launch(name, work)
        if stay.any():
            self._device.put_back(before, stay)
        self._fetch(ids)

    def _fetch(self, ids: Any) -> None:
        at = slice(None) if ids is None else np.asarray(ids)
        for name, mirror in self._derived.items():
            if name not in _SELDOM:
                mirror[at] = self._device.read(name).reshape(mirror.shape)[at]
        if "sensordata" in self._derived:
            self._limits.meet(self._derived["sensordata"])

    def _went_on(self, ids: Any, count: int) -> None:
        at = slice(None) if ids is None else np.asarray(ids)
        self.time[at] += count * self._steps[at]
        self._old = True
        self._look()

    def _look(self) -> None:
        """Warn of arms that are no longer finite, and put them straight: the solver would go on about them for long."""
        bad = ~(np.abs(self.bind("sensordata")) < _HUGE).all(axis=1)
        if not bad.any():
            return
        self.pull()
        for place in np.flatnonzero(bad & ~self._gone).tolist():
            qpos, qvel = (self._rows[place, self._columns(_MOVES[name])] for name in ("qpos", "qvel"))
            wrong = ~((np.abs(qpos) < _HUGE) & (np.abs(qvel) < _HUGE))
            self.warning[place, _BAD] = int(wrong.argmax()), self.warning[place, _BAD, 1] + 1
        self._rows[bad], self.time[bad] = 0.0, 0.0
        self._gone |= bad
        self._written = True

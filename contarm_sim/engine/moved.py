"""What moves many arms in the engine: posed, sent controls, stepped, and frozen where they diverge."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.divergence import FATAL, any_fatal, divergence, stepping_settings
from contarm_sim.engine.plant import bent
from contarm_sim.engine.seen import SeenArms
from contarm_sim.errors import DivergenceError
from contarm_sim.kinematics.arrays import Array

Places = NDArray[np.integer] | Sequence[int] | None
"""Which of the arms, rising; None: all."""

STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)
"""What an arm goes on from."""


class MovedArms(SeenArms):
    """B arms of one layout on their way; see `Plants`, which says what its attributes are."""

    failed: dict[int, DivergenceError]

    def go_back(self, rows: Array) -> None:
        """Go on from states, shape (B, size), as of `state`, and derive everything of them."""
        self.state[:] = rows
        self.forward()
        self.state[:] = rows

    def reset(self, places: Places = None, bend: Array | None = None) -> None:
        """Put arms at rest with all joints of a section bent alike, as `Plant.reset`; `forward` derives the rest.

        Args:
            places: of the arms.
            bend: of each of these arms and sections [rad], shape (len(places), 2 S); default straight.
        """
        at = self._every(places)
        self._clear(at)
        self.batch.reset(at, keyframe=0, stage=int(mujoco.mjtStage.mjSTAGE_NONE))
        if bend is not None:
            for place, one in zip(at.tolist(), bend, strict=True):
                bent(self.qpos[place], self.arms[place], self.index, one)

    def restart(self, places: Places, qpos: Array, control: Array) -> None:
        """Put arms at rest with joint angles [rad], shape (P, D), controls, shape (P, M), sent and reached."""
        at = self._every(places)
        self._clear(at)
        start = {"keyframe": 0} if self._own[0].hosted else {}  # a host starts from its own
        self.batch.reset(at, stage=int(mujoco.mjtStage.mjSTAGE_NONE), **start)
        self.qpos[at] = qpos
        self.send(control, at)
        if self.pressure.size:
            self.pressure[at] = control if self.pressure.ndim == 2 else np.asarray(control)[:, None]
        self.forward(at)

    def send(self, control: Array, places: Places = None) -> None:
        """Assign controls, shape (P, M), to all actuators of the muscles."""
        at: Any = slice(None) if places is None else places
        self.control[at] = control if self.control.ndim == 2 else np.asarray(control)[:, None]

    def forward(self, places: Places = None) -> None:
        """Derive everything of the present states."""
        self.batch.forward(None if places is None else self._every(places))

    def step(
        self,
        substeps: int = 1,
        places: Places = None,
        stage: mujoco.mjtStage = mujoco.mjtStage.mjSTAGE_NONE,
        check: bool = True,
    ) -> None:
        """Take engine steps with all arms that have not failed, or with those of these places.

        Args:
            substeps: how many.
            places: of the arms.
            stage: what is derived of the new state afterwards, see `Batch.step`.
            check: look for arms that diverged; without, call `check` before long.
        """
        at = self._going(places)
        if at is not None and not len(at):
            return
        before = self.batch.time.copy() if check else None
        self.batch.step(at, substeps, int(stage))
        if check:
            self.check(before)

    def check(self, times: Array | None = None) -> bool:
        """Note which arms diverged in `failed`; return whether any did since the last look.

        Args:
            times: when, of each arm, for the errors [s], shape (B,); default what the engine's clocks say, which starts
                again with an arm that diverged.
        """
        if not any_fatal(self._numbers):
            return False
        told = self.batch.time if times is None else times
        bad = np.flatnonzero(self._numbers[:, FATAL].any(axis=1)).tolist()
        new = [place for place in bad if place not in self.failed]
        for place in new:
            model, arm = self.models[place], self.arms[place]
            self.failed[place] = divergence(
                model, self._numbers[place], self._last[place], float(told[place]), stepping_settings(model, arm)
            )
        return bool(new)

    def _clear(self, places: NDArray[np.integer]) -> None:
        for place in places.tolist():
            self.failed.pop(place, None)

    def _every(self, places: Places) -> NDArray[np.integer]:
        return np.arange(len(self.arms)) if places is None else np.asarray(places, dtype=int)

    def _going(self, places: Places) -> NDArray[np.integer] | None:
        """Return which of these arms have not failed; None for all of all."""
        if not self.failed:
            return None if places is None else np.asarray(places, dtype=int)
        at = self._every(places)
        return at[~np.isin(at, list(self.failed))]

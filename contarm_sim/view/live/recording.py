"""What the live arm does, kept sample by sample, to be a trajectory in the end."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.engine.recorder import Recorder
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.paths.reference import Reference
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.versions import versions

LONGEST = 600.0
"""Simulated time after which a recording ends by itself [s]."""

_BLOCK = 500
"""Samples that room is made for at once."""


class Recording:
    """Samples of a plant, one a control tick.

    Args:
        plant: in motion.
        about: controller, actuation and what else a trajectory knows of what drives it.
        period: of the control ticks [s].

    Attributes:
        ended: whether the plant, or what drives it, is another one by now.
    """

    def __init__(self, plant: Plant, about: dict[str, Any], period: float) -> None:
        self._plant, self._about, self._period = plant, about, period
        self._timestep, self._began = float(plant.model.opt.timestep), time.perf_counter()
        self._blocks: list[Recorder] = []
        self._sent: list[tuple[Array, Array]] = []
        self.ended = False

    @property
    def duration(self) -> float:
        """Simulated time that is recorded [s]."""
        return max(len(self._sent) - 1, 0) * self._period

    def take(self, bend: Array, setpoint: Array) -> None:
        """Keep what the engine last derived from a state, with the bend [rad] commanded then and what was sent."""
        if self.ended:
            return
        count = len(self._sent)
        if count == len(self._blocks) * _BLOCK:
            self._blocks.append(Recorder(self._plant, _BLOCK))
        self._blocks[-1].take(count % _BLOCK)
        self._sent.append((bend.copy(), setpoint.copy()))  # last: an interrupted sample does not count
        self.ended = self.duration >= LONGEST

    def trajectory(self) -> Trajectory | None:
        """Return what was recorded, from time 0 on, as a motion towards the tips of the arcs; None of less than two."""
        count = len(self._sent)
        if count < 2:
            return None
        times: Any = self._period * np.arange(count)
        arm = self._plant.arm
        bend, setpoint = (np.array(part) for part in zip(*self._sent, strict=True))
        filled = [min(_BLOCK, count - _BLOCK * i) for i in range(len(self._blocks))]
        parts = [block.arrays(own) for block, own in zip(self._blocks, filled, strict=True) if own > 0]
        touched = [part.pop("contacts") for part in parts if "contacts" in part]
        arrays: dict[str, Any] = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        if touched:
            arrays["contacts"] = Contacts.joined(touched, filled)
        reference = Reference.from_bends(bend, arm, times)
        return Trajectory(
            arm=arm, **self._about, status="finished", time=times, target=reference.target, bend=bend,
            setpoint=setpoint, **arrays, timestep=self._timestep,
            real_time_factor=self.duration / max(time.perf_counter() - self._began, 1e-9), versions=versions(),
        )  # fmt: skip

"""Models and states of many arms on one device of Warp's, and what is done with them, recorded as graphs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.warp_library import library, quiet
from contarm_sim.engine.warp_models import WarpModels
from contarm_sim.kinematics.arrays import Array

_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION) & ~int(mujoco.mjtState.mjSTATE_PLUGIN)
"""What a row of states holds: as in the engine itself, where arms have no plugins."""


class WarpDevice:
    """Arms on a CUDA device where there is one, and on the processor where there is none.

    Launching its hundred kernels one by one takes Python 4 ms a step; so all that is done often is recorded once, as a
    graph, and launched as one.

    Args:
        models: of the arms.
        shape: of their states, see `mjSTATE_INTEGRATION`.

    Attributes:
        model, data: MuJoCo Warp's.

    Raises:
        InputError: models that differ in what MuJoCo Warp keeps once for all arms.
    """

    def __init__(self, models: Sequence[mujoco.MjModel], shape: tuple[int, int]) -> None:
        self._wp, self._mjw = library()
        self._graphs: dict[Any, Any] = {}
        self._buffers: dict[Any, Any] = {}
        with quiet():
            self._place = self._wp.get_preferred_device()
        with quiet(), self._wp.ScopedDevice(self._place):
            self._models = WarpModels(models)
            self.model, self.data = self._models.model, self._models.data(len(models))
            self._active = self._wp.zeros(len(models), dtype=bool)
        self._shape = shape

    def take(self, models: Sequence[mujoco.MjModel]) -> bool:
        """Take the parameters of these models in place; return whether that can be.

        Raises:
            InputError: as above.
        """
        with quiet(), self._wp.ScopedDevice(self._place):
            return self._models.take(models)

    def write(self, name: str, values: Array) -> None:
        """Write a field of the models of all arms, shape (B, ...)."""
        with quiet(), self._wp.ScopedDevice(self._place):
            self._models.write(name, values)

    def buffer(self, name: Any, shape: tuple[int, ...]) -> Any:
        """Return an array on the device, the same each time."""
        if name not in self._buffers:
            with quiet(), self._wp.ScopedDevice(self._place):
                self._buffers[name] = self._wp.zeros(shape, dtype=float)
        return self._buffers[name]

    def send(self, array: Any, values: Array) -> None:
        """Bring values over to an array on the device."""
        with quiet(), self._wp.ScopedDevice(self._place):
            array.assign(np.ascontiguousarray(values, dtype=np.float32))

    def copy(self, to: Any, array: Any) -> None:
        """Copy on the device."""
        self._wp.copy(to, array)

    def read(self, name: str) -> Array:
        """Return a field of the engine's data, shape (B, ...)."""
        return np.asarray(getattr(self.data, name).numpy())

    def states(self, name: str) -> Any:
        """Return the states of all arms as an array on the device, the same for each name."""
        rows = self.buffer(name, self._shape)
        self.launch(name, lambda: self._mjw.get_state(self.model, self.data, rows, _STATE))
        return rows

    def go_on_from(self, rows: Array) -> None:
        """Put all arms into states, shape (B, size)."""
        sent = self.buffer("sent", self._shape)
        self.send(sent, rows)
        self.put_back(sent, np.ones(len(rows), dtype=bool))

    def put_back(self, states: Any, which: NDArray[np.bool_]) -> None:
        """Put some of the arms, shape (B,), into states on the device."""
        with quiet(), self._wp.ScopedDevice(self._place):
            self._active.assign(which)
        self.launch(
            ("put back", id(states)),
            lambda: self._mjw.set_state(self.model, self.data, states, _STATE, self._active),
        )

    def launch(self, name: Any, work: Callable[[], object]) -> None:
        """Do what goes by a name, which is recorded the first time."""
        with quiet(), self._wp.ScopedDevice(self._place):
            if name not in self._graphs:
                with self._wp.ScopedCapture() as capture:
                    work()
                self._graphs[name] = capture.graph
            self._wp.capture_launch(self._graphs[name])

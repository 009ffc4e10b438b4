"""Forces at their limits, as they were before they were rounded to single precision."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from contarm_sim.kinematics.arrays import Array


class ForceLimits:
    """What sensors of muscles' forces read where an actuator is at a limit [N].

    Whether a servo is at its limit, `control` asks by comparing: 177.3786 N, as single precision has it, is below a
    limit of 177.37860521 N, so it would never be.

    Args:
        models: of B arms of one layout.
    """

    def __init__(self, models: Sequence[mujoco.MjModel]) -> None:
        first = models[0]
        tendons = np.where(first.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON, first.actuator_trnid[:, 0], -1)
        columns: list[int] = []
        actuators: list[int] = []
        for sensor in np.flatnonzero(first.sensor_type == mujoco.mjtSensor.mjSENS_TENDONACTFRC):
            pulling = np.flatnonzero(tendons == first.sensor_objid[sensor])
            if len(pulling) == 1:  # of several it is their sum
                columns.append(int(first.sensor_adr[sensor]))
                actuators.append(int(pulling[0]))
        self._columns = columns
        self._exact = np.stack([model.actuator_forcerange[actuators] for model in models])
        self._rounded = self._exact.astype(np.float32).astype(float)

    def meet(self, sensors: Array) -> None:
        """Put the limits in place of what they were rounded to, in sensor data of all arms, shape (B, sensors)."""
        read = sensors[:, self._columns]
        for side in (0, 1):
            read = np.where(read == self._rounded[..., side], self._exact[..., side], read)
        sensors[:, self._columns] = read

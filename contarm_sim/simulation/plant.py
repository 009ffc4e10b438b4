"""The engine behind named quantities: model and data of one simulated arm."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np
from threadpoolctl import threadpool_limits

from contarm_sim.arm import Arm
from contarm_sim.errors import DivergenceError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import force_slope, passive_slope, passive_tension
from contarm_sim.mjcf import Actuation, arm_spec
from contarm_sim.mjcf.muscles import MUSCLES

FATAL = [
    int(warning)
    for warning in (
        mujoco.mjtWarning.mjWARN_BADQPOS,
        mujoco.mjtWarning.mjWARN_BADQVEL,
        mujoco.mjtWarning.mjWARN_BADQACC,
    )
]
"""Warnings after which the engine has reset the arm."""


@contextmanager
def engine_room() -> Iterator[None]:
    """Run simulations inside: no warnings written to MUJOCO_LOG.TXT, no BLAS threads.

    `Plant.check` reads the engine's warning counters instead. The matrices here are small: a second BLAS thread gains
    nothing, and spins beside the stepping loop until that takes twice as long.
    """
    with quiet_engine(), threadpool_limits(1, user_api="blas"):
        yield


@contextmanager
def quiet_engine() -> Iterator[None]:
    """Keep the engine from writing warnings to MUJOCO_LOG.TXT; its counters still tell."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_ignore)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)


def _ignore(message: str) -> None:
    pass


class Plant:
    """A simulated arm. The base frame is the engine's world frame; gravity is the arm's.

    Args:
        arm: its parameters.
        pull_only: limit muscle forces to pulling, at most the blocked force. False gives plain
            position servos, which also push: what the paper's lengths meet when read naively.
        timestep: engine step [s]; default the model's.
        integrator: engine integrator; default the model's.
        actuation: `lengths` (servos), `pressures` (McKibben muscles behind valves) or `tensions` (plain forces).

    Attributes:
        model, data: the engine's.
        centres: what `stations` copies, as a view into the engine's memory that stays current.
        control: the engine's controls as a view, one column a muscle: assign set-points [m], pressures [Pa] or
            tensions [N], shape (3,), to all of it.
        pressure: pressures behind the valves [Pa], a view like `control`; empty for servos.
    """

    def __init__(
        self,
        arm: Arm,
        pull_only: bool = True,
        timestep: float | None = None,
        integrator: mujoco.mjtIntegrator | None = None,
        actuation: Actuation = "lengths",
    ) -> None:
        self.arm = arm
        self.model = arm_spec(arm, actuation).compile()
        if not pull_only:
            self.model.actuator_forcelimited[:] = 0
            self.model.actuator_ctrllimited[:] = 0
        if timestep is not None:
            self.model.opt.timestep = timestep
        if integrator is not None:
            self.model.opt.integrator = integrator
        self.data = mujoco.MjData(self.model)
        # Views into the engine's memory: they stay current, and cost nothing to look up in a loop.
        self.centres = self.data.xpos[self.model.body("base").id : self.model.body("tip").id + 1]
        self.control = self.data.ctrl.reshape(-1, 3)
        self.pressure = self.data.act.reshape(-1, 3)
        self._warnings = self.data.warning.number
        self._bending = {
            axis: np.array([self.model.joint(f"joint_{i:02d}_{axis}").qposadr[0] for i in range(1, arm.links + 1)])
            for axis in "xy"
        }
        stations = range(self.model.body("base").id, self.model.body("tip").id + 1)
        names = [[f"{self.model.body(i).name}_{muscle}" for i in stations] for muscle in MUSCLES]
        self._guides = np.array([[self.model.site(name).id for name in row] for row in names])

    @property
    def muscle_lengths(self) -> Array:
        """Muscle lengths [m], shape (3,)."""
        return self.data.ten_length.copy()

    @property
    def muscle_tensions(self) -> Array:
        """Muscle tensions [N], pulling > 0, shape (3,): by actuators and by stretched silicone."""
        return self.muscle_forces + passive_tension(self.data.ten_length, self.arm)

    @property
    def muscle_forces(self) -> Array:
        """What the actuators pull with [N], pulling > 0, shape (3,)."""
        return -self.data.actuator_force.reshape(-1, 3).sum(axis=0)

    @property
    def muscle_slopes(self) -> Array:
        """What tensions gain by length [N/m], shape (3,), controls and pressures as they are."""
        model, data = self.model, self.data
        silicone = passive_slope(data.ten_length, self.arm)
        if len(self.pressure):
            return force_slope(self.pressure[0], data.ten_length, self.arm) + silicone
        low, high = model.actuator_forcerange.T
        at_limit = (model.actuator_forcelimited != 0) & ((data.actuator_force <= low) | (data.actuator_force >= high))
        return np.where(at_limit, 0.0, -model.actuator_biasprm[:, 1]) + silicone

    @property
    def muscle_damping(self) -> Array:
        """What forces gain by the speed of lengthening [N s/m], shape (3,)."""
        if len(self.pressure):
            return np.zeros(3)
        low, high = self.model.actuator_forcerange.T
        force = self.data.actuator_force
        at_limit = (self.model.actuator_forcelimited != 0) & ((force <= low) | (force >= high))
        return np.where(at_limit, 0.0, -self.model.actuator_biasprm[:, 2])

    @property
    def stations(self) -> Array:
        """Centres of base plate, disks and tip plate [m], shape (links + 1, 3)."""
        return self.centres.copy()

    @property
    def tip(self) -> Array:
        """Tip position [m], shape (3,)."""
        return self.centres[-1].copy()

    @property
    def tip_rotation(self) -> Array:
        """Orientation of the tip, shape (3, 3)."""
        return self.rotations[-1]

    @property
    def rotations(self) -> Array:
        """Orientations of base plate, links and tip, shape (links + 1, 3, 3)."""
        first = self.model.body("base").id
        return self.data.xmat[first : first + self.arm.links + 1].reshape(-1, 3, 3).copy()

    @property
    def muscle_paths(self) -> Array:
        """Points that the muscles run through, straight from one to the next [m], shape (3, links + 1, 3)."""
        return self.data.site_xpos[self._guides]

    def reset(self, bend: Array) -> None:
        """Put the arm at rest with every joint bent alike, the first guess of a pose at this bend [rad]."""
        mujoco.mj_resetDataKeyframe(self.model, self.data, 0)
        self.data.qpos[self._bending["x"]] = -bend[1] / self.arm.links
        self.data.qpos[self._bending["y"]] = bend[0] / self.arm.links

    def check(self, settings: dict[str, Any]) -> None:
        """Raise if the engine met a bad state: it would reset the arm and carry on as if nothing had happened.

        Raises:
            DivergenceError: with the time, the degree of freedom and the settings.
        """
        if any(self._warnings.tolist()) and self._warnings[FATAL].any():
            fatal = next(self.data.warning[i] for i in FATAL if self.data.warning[i].number)
            dof = int(fatal.lastinfo)
            name = self.model.joint(self.model.dof_jntid[dof]).name if 0 <= dof < self.model.nv else "?"
            raise DivergenceError(float(self.data.time), dof, name, settings)

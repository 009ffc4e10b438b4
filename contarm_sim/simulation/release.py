"""Free swing: the arm held by a load until time zero, then let go; and the modes that it should swing in."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.load import Load
from contarm_sim.simulation.equilibrium import driven_plant, equilibrium
from contarm_sim.simulation.loads import AppliedLoad
from contarm_sim.simulation.plant import engine_room
from contarm_sim.simulation.stiffness import TangentStiffness

SAMPLE_PERIOD = 0.01
"""Time between samples [s]."""


@dataclass(frozen=True)
class Swing:
    """T samples of a released arm.

    Attributes:
        time: since the release [s], shape (T,).
        tip: [m], shape (T, 3).
        energy: kinetic, elastic and of weight [J], shape (T,).
    """

    time: Array
    tip: Array
    energy: Array


def remaining(load: Load) -> Load:
    """Return what is left of a load once it is let go: its muscles, driven as they were."""
    return Load(muscles=load.muscles)


def release(arm: Arm, held: Array, load: Load, timestep: float, duration: float) -> Swing:
    """Let go at joint angles [rad], shape (dofs,), and record; the load's muscles stay driven as they are.

    Raises:
        InputError: a step that does not divide the sample period, 10 ms.
        DivergenceError: the engine met a bad state.
    """
    steps = SAMPLE_PERIOD / timestep
    if round(steps) < 1 or abs(steps - round(steps)) > 1e-6:
        raise InputError("timestep", f"{timestep:g} s", f"a whole fraction of {SAMPLE_PERIOD:g} s")
    plant = driven_plant(arm, remaining(load))
    model, data = plant.model, plant.data
    model.opt.timestep = timestep
    data.qpos[:] = held
    count = round(duration / SAMPLE_PERIOD) + 1
    tip, energy = np.empty((count, 3)), np.empty(count)
    with engine_room():
        for i in range(count):
            if i:
                mujoco.mj_step(model, data, round(steps))
                plant.check({"timestep": timestep})
            mujoco.mj_fwdPosition(model, data)  # poses and energies of this time, not of a step earlier
            mujoco.mj_energyPos(model, data)
            mujoco.mj_energyVel(model, data)
            tip[i], energy[i] = plant.tip, data.energy.sum()
    return Swing(SAMPLE_PERIOD * np.arange(count, dtype=float), tip, energy)


def natural_frequencies(arm: Arm, load: Load, count: int) -> Array:
    """Return the lowest natural frequencies [Hz], shape (count,), undamped, about the rest left when a load is let go.

    Raises:
        ConvergenceError: there is no such rest.
    """
    from scipy.linalg import eigh

    left = remaining(load)
    plant = driven_plant(arm, left)
    model, data = plant.model, plant.data
    data.qpos[:] = equilibrium(arm, left).qpos
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    K = TangentStiffness(plant, AppliedLoad(plant, left))()
    squares = eigh(0.5 * (K + K.T), M, eigvals_only=True, subset_by_index=[0, min(count, model.nv) - 1])
    return np.sqrt(np.maximum(squares, 0)) / (2 * np.pi)


CLAMPED_FREE = np.array([1.8751040687, 4.6940911330, 7.8547574382])
"""Roots of cosh x cos x = -1: the modes of a clamped beam."""


def beam_frequencies(arm: Arm) -> Array:
    """Return the lowest natural frequencies [Hz] of a clamped beam, shape (3,): no muscles, gravity, payload."""
    return CLAMPED_FREE**2 * np.sqrt(arm.bending_stiffness / (arm.mass * arm.length**3)) / (2 * np.pi)


def bare(arm: Arm) -> Arm:
    """Return the arm that `beam_frequencies` speaks of."""
    return replace(arm.unloaded, torsional_stiffness=None)

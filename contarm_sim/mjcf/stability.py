"""The longest time step at which an arm cannot blow up.

The engine (`implicitfast`) is implicit in damping C and explicit in stiffness K: with the mass matrix M, a step dt is
stable where 4 M + 2 dt C - dt^2 K is positive definite. Loads are small beside K and left out.
"""

from __future__ import annotations

import mujoco
import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.mjcf.muscles import Actuation, stiffest
from contarm_sim.model.arm import Arm

MARGIN = 1.3
"""Factor by which a step stays below what linear theory calls unstable: the arm bends, and its inertia changes."""

SHORTEST = 1e-6
"""Shortest step [s] that is tried."""


def is_stable(model: mujoco.MjModel, data: mujoco.MjData, arm: Arm, actuation: Actuation, timestep: float) -> bool:
    """Tell whether an arm compiled alone is stable at a time step [s] in its pose; positions must be up to date."""
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    J = tendon_jacobian(model, data)
    damping = np.diag(model.dof_damping) + (J.T * model.tendon_damping) @ J
    stiffness = np.diag(model.jnt_stiffness) + (J.T * stiffest(arm, actuation)) @ J
    try:
        np.linalg.cholesky(4 * mass + 2 * timestep * damping - (MARGIN * timestep) ** 2 * stiffness)
    except np.linalg.LinAlgError:
        return False
    return True


def tendon_jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Return what tendon lengths gain by joint angles [m/rad], shape (tendons, dofs)."""
    J = np.zeros((model.ntendon, model.nv))
    if model.ntendon:
        mujoco.mju_sparse2dense(J, data.ten_J, model.ten_J_rownnz, model.ten_J_rowadr, model.ten_J_colind)
    return J


def longest_step(model: mujoco.MjModel, arm: Arm, actuation: Actuation, most: float) -> float:
    """Return a stable time step [s] for an arm compiled alone: `most`, or a half, a fifth, a tenth, ... of it.

    Raises:
        InputError: no step down to `SHORTEST` is stable; says what to change.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    shares, power = (1.0, 0.5, 0.2), 0
    while most * 10.0**power >= SHORTEST:
        for share in shares:
            step = float(f"{most * share * 10.0**power:.12g}")
            if is_stable(model, data, arm, actuation, step):
                return step
        power -= 1
    raise unstable(arm)


def unstable(arm: Arm) -> InputError:
    """Return the error that says that no time step suits an arm, and what to change."""
    damping = min(section.damping_time for section in arm.sections)
    return InputError(
        "damping_time",
        f"{damping:g} s, at which no time step down to {SHORTEST:g} s is stable",
        "more damping, fewer links, more mass, or softer servos (--muscle.servo-stiffness)",
    )

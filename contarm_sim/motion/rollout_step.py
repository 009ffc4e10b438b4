"""The step of rollouts: stable with friction in the backbone too, and short beside the lowest natural period."""

from __future__ import annotations

import mujoco
import numpy as np

from contarm_sim.engine.models import built
from contarm_sim.mjcf import Actuation
from contarm_sim.mjcf.muscles import stiffest
from contarm_sim.mjcf.stability import SHORTEST, is_stable, tendon_jacobian, unstable
from contarm_sim.model.arm import Arm

LONGEST = 0.002
"""Longest step [s]."""

PERIOD = 100
"""Fewest steps in a period of the lowest natural frequency: leapfrog then errs by 0.02 % of it."""


def step_for(arm: Arm, actuation: Actuation) -> float:
    """Return a step [s] at which an arm is stable, friction in its backbone too, and its first mode is right.

    Raises:
        InputError: no step is stable; says what to change.
    """
    from scipy.linalg import eigh

    own = built(arm.without_memory, actuation)
    model, data = own.model, mujoco.MjData(own.model)
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    J = tendon_jacobian(model, data)
    stiffness = np.diag(model.jnt_stiffness) + (J.T * stiffest(arm, actuation)) @ J
    (lowest,) = eigh(stiffness, mass, eigvals_only=True, subset_by_index=[0, 0])
    most = min(LONGEST, 2 * np.pi / np.sqrt(lowest) / PERIOD)
    sticking = np.array([section.sticking_stiffness for section in arm.sections])[own.index.section_of_joint]
    bending = np.concatenate(list(own.index.bending.values()))
    model.jnt_stiffness[bending] += sticking[bending]
    for step in (share * 10.0**power for power in range(-3, -7, -1) for share in (2.0, 1.0, 0.5, 0.2)):
        if SHORTEST <= step <= most * (1 + 1e-9) and is_stable(model, data, arm, actuation, step):
            return float(f"{step:.12g}")
    raise unstable(arm)

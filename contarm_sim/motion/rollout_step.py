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


BESIDE = 1.05
"""How far an arm's limit may be from that of another step for the arm to keep that step."""


def step_for(arm: Arm, actuation: Actuation, usual: float | None = None) -> float:
    """Return a step [s] at which an arm is stable, friction in its backbone too, and its first mode is right.

    Args:
        arm: of which.
        actuation: how it is driven.
        usual: step of an arm that this one may differ from a little; kept where a limit within 5 % of the arm's has it,
            so that derivatives are of arms of one step.

    Raises:
        InputError: no step is stable; says what to change.
    """
    from scipy.linalg import eigh

    made = built(arm.without_memory, actuation)
    model, data = made.model, mujoco.MjData(made.model)
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    J = tendon_jacobian(model, data)
    stiffness = np.diag(model.jnt_stiffness) + (J.T * stiffest(arm, actuation)) @ J
    (lowest,) = eigh(stiffness, mass, eigvals_only=True, subset_by_index=[0, 0])
    most = min(LONGEST, 2 * np.pi / np.sqrt(lowest) / PERIOD)
    sticking = np.array([section.sticking_stiffness for section in arm.sections])[made.index.section_of_joint]
    bending = np.concatenate(list(made.index.bending.values()))
    model.jnt_stiffness[bending] += sticking[bending]

    def longest(reserve: float) -> float:
        for step in (share * 10.0**power for power in range(-3, -7, -1) for share in (2.0, 1.0, 0.5, 0.2)):
            held = reserve * step
            if step >= SHORTEST and held <= most * (1 + 1e-9) and is_stable(model, data, arm, actuation, held):
                return float(f"{step:.12g}")
        return 0.0

    own = longest(1.0)
    if usual is not None and own != usual and longest(BESIDE) <= usual <= longest(1 / BESIDE):
        return usual
    if not own:
        raise unstable(arm)
    return own

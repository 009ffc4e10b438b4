"""Whether a small disturbance of a pose at rest dies out, also under loads that no energy belongs to."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from contarm_sim.kinematics.arrays import Array

if TYPE_CHECKING:
    from contarm_sim.simulation.solver import Solver


def growth(solver: Solver) -> float:
    """Return the largest real part [1/s] of the eigenvalues of the linearised motion; NaN for loads with energy.

    The solver's pose must be evaluated.
    """
    if solver.stiffness.symmetric:
        return float("nan")
    plant = solver.plant
    model, data = plant.model, plant.data
    K = solver.stiffness.matrix(solver.tensions, plant.muscle_slopes)
    mujoco.mj_fwdPosition(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    J = plant.muscle_jacobian
    C = np.diag(model.dof_damping) + (J.T * plant.damping) @ J
    return fastest(M, C, K)


def fastest(M: Array, C: Array, K: Array) -> float:
    """Return the largest real part [1/s] of the eigenvalues of M q'' + C q' + K q = 0."""
    A = np.block([[np.zeros_like(K), np.eye(len(K))], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    return float(np.linalg.eigvals(A).real.max())

"""Whether a small disturbance of a pose at rest dies out, also under loads that no energy belongs to."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from contarm_sim.kinematics.arrays import Array

if TYPE_CHECKING:
    from contarm_sim.statics.poses import Poses
    from contarm_sim.statics.solver import Solver


def growth(solver: Solver, stiffness: Array | None = None, free: Array | None = None) -> float:
    """Return the largest real part [1/s] of the eigenvalues of the linearised motion.

    NaN for loads with energy; minus infinity where `damped_out` spares the eigenvalues. The solver's pose must be
    evaluated.

    Args:
        stiffness: [N m/rad], shape (dofs, dofs); default the solver's own.
        free: a basis of the changes that the arm can make, shape (dofs, free); default all.
    """
    if solver.stiffness.symmetric:
        return float("nan")
    plant = solver.plant
    K = solver.stiffness.matrix(solver.tensions, plant.muscle_slopes) if stiffness is None else stiffness
    M = _inertia(plant.model, plant.data)
    C = _damping(plant.model.dof_damping, plant.damping, plant.muscle_jacobian)
    if free is not None:
        M, C, K = (free.T @ each @ free for each in (M, C, K))
    return _rate(M, C, K)


def growth_at(poses: Poses, row: int, K: Array) -> float:
    """Return what `growth` does of one of many poses whose loads have no energy, K being its stiffness [N m/rad]."""
    J = poses.muscle_jacobian
    C = _damping(poses.dof_damping[row], poses.damping[row], J[row] if J.ndim > 2 else J)
    with poses.engine_at(row) as engine:
        M = _inertia(*engine)
    return _rate(M, C, K)


def _rate(M: Array, C: Array, K: Array) -> float:
    return -np.inf if damped_out(M, C, K) else fastest(M, C, K)


def _inertia(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Return the mass matrix at the engine's joint angles."""
    mujoco.mj_fwdPosition(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    return M


def _damping(of_joints: Array, of_muscles: Array, J: Array) -> Array:
    return np.asarray(np.diag(of_joints) + (J.T * of_muscles) @ J)


def damped_out(M: Array, C: Array, K: Array) -> bool:
    """Whether a bound proves that all motions of M q'' + C q' + K q = 0 die out; False proves nothing.

    A mode x has m s^2 + c s + k + i n = 0, with m, c and k the quotients of M, C and the symmetric part of K, n that of
    its skew part: it dies out if k > 0 and c^2 k > m n^2. All are taken by k, and each at its worst.
    """
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(0.5 * (K + K.T)))
    except np.linalg.LinAlgError:
        return False
    skew = np.linalg.norm(inverse @ (0.5 * (K - K.T)) @ inverse.T)
    inertia = np.trace(inverse @ M @ inverse.T)
    damping = np.linalg.eigvalsh(inverse @ C @ inverse.T)[0]
    return bool(damping > 0 and damping**2 > inertia * skew**2)


def fastest(M: Array, C: Array, K: Array) -> float:
    """Return the largest real part [1/s] of the eigenvalues of M q'' + C q' + K q = 0."""
    A = np.block([[np.zeros_like(K), np.eye(len(K))], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    return float(np.linalg.eigvals(A).real.max())

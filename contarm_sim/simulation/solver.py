"""Static equilibrium of a plant: Newton, then pseudo-transient, then load continuation.

Newton with the closed-form stiffness converges in a handful of steps, but may land where the arm would not stay.
Pseudo-transient steps (K + mu diag(k)) dq = Q follow the arm as a strongly damped one would move, so they end in stable
poses only.
Continuation raises the loads from nothing, each pose the guess for the next: the way a load is put on an arm.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import ConvergenceError, InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.load import Load
from contarm_sim.simulation.loads import AppliedLoad
from contarm_sim.simulation.plant import Plant
from contarm_sim.simulation.stiffness import TangentStiffness

METHODS = ("auto", "newton", "pseudo-transient")

RESIDUAL = 1e-9
"""Largest generalised force left at rest [N m]."""

TOTAL_STEP = 4.0
"""Largest change of the joint angles' sum in one step, were all as large as the largest [rad]."""

SMALLEST_INCREMENT = 1e-3
"""Continuation gives up below this fraction of the load."""


@dataclass(frozen=True)
class Solution:
    """How a solution ended.

    Attributes:
        residual: largest generalised force left [N m].
        smallest_eigenvalue: of the stiffness matrix (its real part, where loads have no energy) [N m/rad].
        growth: fastest growth of a small disturbance [1/s], negative if all die out; under loads that no energy belongs
            to (dead couples, followers) the arm may flutter though its stiffness matrix has no negative eigenvalue. NaN
            for loads with energy, where that cannot be.
        iterations: evaluations of the stiffness matrix.
    """

    residual: float
    smallest_eigenvalue: float
    growth: float
    iterations: int

    @property
    def stable(self) -> bool:
        """Whether the arm would stay there."""
        return self.smallest_eigenvalue > 0 and not self.growth > 0


class _Whole:
    """What continuation raises beside the load: gravity, pressures, constant tensions; set-points stay."""

    def __init__(self, plant: Plant) -> None:
        self._gravity, self._pressure = plant.model.opt.gravity.copy(), plant.pressure.copy()
        self._tensions = plant.control.copy() if plant.constant_tensions else None

    def apply(self, plant: Plant, fraction: float) -> None:
        plant.model.opt.gravity[:] = fraction * self._gravity
        plant.pressure[:] = fraction * self._pressure
        if self._tensions is not None:
            plant.control[:] = fraction * self._tensions


class Solver:
    """Moves a plant to the equilibrium near its current pose, under a load and the servos' set-points.

    Attributes:
        load: the load on this plant; its `fraction` is what continuation raises.
        extra: generalised forces beside the load [N m], shape (dofs,); 0 unless set.
        forces: generalised forces left at the last pose evaluated [N m], shape (dofs,); zero at rest.
        iterations: evaluations of the stiffness matrix since the last call.
    """

    def __init__(self, plant: Plant, load: Load | None = None) -> None:
        self._plant = plant
        self.load = AppliedLoad(plant, load or Load())
        self._stiffness = TangentStiffness(plant, self.load)
        self._scale = plant.model.jnt_stiffness.copy()
        self._largest = TOTAL_STEP / plant.arm.links
        self.extra: Array | float = 0.0
        self.forces: Array = np.zeros(plant.model.nv)
        self.iterations = 0

    def __call__(self, setpoint: Array) -> float:
        """Settle by Newton under set-points [m] or pressures [Pa], shape (3,); return the residual [N m].

        Raises:
            ConvergenceError: no equilibrium near, or only an unstable one.
        """
        self._plant.control[:] = setpoint
        if len(self._plant.pressure):
            self._plant.pressure[:] = setpoint  # the valves have settled too
        self.iterations = 0
        residual = self.newton()
        if residual > RESIDUAL:
            raise ConvergenceError("settling", residual, RESIDUAL, self.iterations, "N m")
        try:
            np.linalg.cholesky(self._stiffness())
        except np.linalg.LinAlgError:
            raise ConvergenceError(
                f"settling found only an unstable pose (softest mode {self.softest():.3g} N m/rad) and",
                residual, RESIDUAL, self.iterations, "N m",
            ) from None  # fmt: skip
        return residual

    def solve(self, method: str = "auto") -> Solution:
        """Find the equilibrium under the whole load.

        Args:
            method: `newton` or `pseudo-transient` alone from the current pose; `auto`: Newton, and
                continuation where that fails or ends in an unstable pose.

        Raises:
            ConvergenceError: says how far it got.
            InputError: an unknown method.
        """
        if method not in METHODS:
            raise InputError("method", repr(method), ", ".join(METHODS))
        start = self._plant.data.qpos.copy()
        self.iterations = 0
        residual = self.pseudo_transient() if method == "pseudo-transient" else self.newton()
        if residual <= RESIDUAL:
            found = Solution(residual, self.softest(), self.growth(), self.iterations)
            if found.stable or method != "auto":
                return found
        elif method != "auto":
            raise ConvergenceError(f"the {method} solver", residual, RESIDUAL, self.iterations, "N m")
        self._plant.data.qpos[:] = start
        residual = self._continue()
        return Solution(residual, self.softest(), self.growth(), self.iterations)

    def newton(self, iterations: int = 40) -> float:
        """Take Newton steps with backtracking; return the residual reached."""
        data, residual = self._plant.data, self.residual()
        for _ in range(iterations):
            if residual <= RESIDUAL:
                break
            step = self._limited(np.linalg.solve(self.tangent(), self.forces))
            start, before = data.qpos.copy(), residual
            for _ in range(10):
                data.qpos[:] = start + step
                residual = self.residual()
                if residual < before:
                    break
                step *= 0.5
        return residual

    def pseudo_transient(self, iterations: int = 400) -> float:
        """Take damped steps, the less damped the smaller the residual; return the residual reached."""
        data = self._plant.data
        residual = first = self.residual()
        damping = 1.0
        for _ in range(iterations):
            if residual <= RESIDUAL:
                break
            K = self.tangent()
            K[np.diag_indices_from(K)] += damping * self._scale
            step = np.linalg.solve(K, self.forces)
            if np.abs(step).max() > self._largest or step @ self.forces < 0:
                damping = max(4 * damping, 1e-3)
                step = self._limited(step) if step @ self.forces > 0 else 0 * step
            data.qpos[:] += step
            before, residual = residual, self.residual()
            first = max(first, residual)
            damping = min(damping * np.clip(residual / max(before, 1e-300), 0.2, 2.0), 1e6)
            if residual < 1e-4 * first:
                damping *= 0.1
        return residual

    def _continue(self) -> float:
        """Raise the load from nothing to the whole, each pose the guess for the next."""
        data = self._plant.data
        whole = _Whole(self._plant)
        reached, increment, residual = 0.0, 0.25, np.inf
        pose = data.qpos.copy()
        while reached < 1.0:
            fraction = min(1.0, reached + increment)
            self._set_fraction(whole, fraction)
            data.qpos[:] = pose
            residual = self.newton(12)
            if residual > RESIDUAL or self.softest() <= 0:
                self._nudge(pose)
                residual = self.pseudo_transient()
            if residual <= RESIDUAL and self.softest() > 0:
                pose, reached, increment = data.qpos.copy(), fraction, 1.5 * increment
            else:
                increment *= 0.5
                if increment < SMALLEST_INCREMENT:
                    self._set_fraction(whole, 1.0)
                    raise ConvergenceError(
                        f"no stable equilibrium near the path beyond {100 * reached:.1f} % of the load: the solver",
                        residual, RESIDUAL, self.iterations, "N m",
                    )  # fmt: skip
        return residual

    def _nudge(self, pose: Array) -> None:
        """Start a little bent towards +X beside a pose, so that a buckling arm has a side to fall to."""
        names = [self._plant.model.joint(i).name[-1] for i in range(self._plant.model.njnt)]
        self._plant.data.qpos[:] = pose + 0.05 / self._plant.arm.links * np.array([name == "y" for name in names])

    def residual(self) -> float:
        """Bring the plant's forces up to date with its pose; return the largest generalised force left [N m]."""
        model, data = self._plant.model, self._plant.data
        data.qvel[:] = 0
        mujoco.mj_fwdPosition(model, data)
        data.qfrc_applied[:] = self.load.generalised_forces() + self.extra
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fwdActuation(model, data)
        self.forces = data.qfrc_passive - data.qfrc_bias + data.qfrc_applied + data.qfrc_actuator
        self.forces += self._plant.stiffen_twist()
        largest = float(np.abs(self.forces).max())
        return largest if np.isfinite(largest) else np.inf

    def softest(self) -> float:
        """Return the smallest eigenvalue of the stiffness matrix at the current pose [N m/rad]."""
        K = self._stiffness()
        return float(np.linalg.eigvalsh(K)[0] if self._stiffness.symmetric else np.linalg.eigvals(K).real.min())

    def growth(self) -> float:
        """Return the largest real part [1/s] of the eigenvalues of the linearised motion; NaN for loads with energy."""
        if self._stiffness.symmetric:
            return float("nan")
        K = self._stiffness()
        model, data = self._plant.model, self._plant.data
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        J = self._plant.muscle_jacobian
        C = np.diag(model.dof_damping) + (J.T * self._plant.damping) @ J
        A = np.block([[np.zeros_like(K), np.eye(model.nv)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
        return float(np.linalg.eigvals(A).real.max())

    def tip_compliance(self) -> Array:
        """Return J K^-1 J^T, shape (6, 6): displacement [m] and rotation [rad] of the tip by force and couple there."""
        model, data = self._plant.model, self._plant.data
        J = np.zeros((6, model.nv))
        mujoco.mj_jacBody(model, data, J[:3], J[3:], model.body("tip").id)
        return J @ np.linalg.solve(self._stiffness(), J.T)

    def tangent(self) -> Array:
        """Return the stiffness matrix at the current pose [N m/rad], shape (dofs, dofs)."""
        self.iterations += 1
        return self._stiffness()

    def _limited(self, step: NDArray[np.floating]) -> Array:
        return np.asarray(step, dtype=float) * min(1.0, self._largest / max(float(np.abs(step).max()), 1e-300))

    def _set_fraction(self, whole: _Whole, fraction: float) -> None:
        self.load.fraction = fraction
        whole.apply(self._plant, fraction)

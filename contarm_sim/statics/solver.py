"""Static equilibrium of a plant under given controls.

Newton with the closed-form stiffness converges in a handful of steps, but may land where the arm would not stay;
`descent` ends in stable poses only. Loads that no energy belongs to (dead couples, followers) leave it no way down:
`continuation` then raises them from nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.statics.descent import STEPS, descend
from contarm_sim.statics.failures import unsettled, unstable
from contarm_sim.statics.loads import AppliedLoad
from contarm_sim.statics.servos import Servos
from contarm_sim.statics.stability import growth
from contarm_sim.statics.stiffness import Swing, TangentStiffness

RESIDUAL = 1e-9
"""Largest generalised force left at rest [N m], for arms that resist bending with up to 1 N m/rad."""

ITERATIONS, HALVINGS = 40, 10
"""Most steps of Newton, and most tries for one."""

TOTAL_STEP = 4.0
"""Largest change of the joint angles' sum in one step, were all as large as the largest [rad]."""


def tolerance(arm: Arm) -> float:
    """Return the largest generalised force left at rest [N m]: `RESIDUAL`, for stiffer arms in proportion.

    Forces that balance to nothing leave their rounding; of an arm that resists a bend with 100 N m/rad they are a
    hundred times larger, and mean a hundredth of the angle.
    """
    return RESIDUAL * max(1.0, arm.bending_resistance)


@dataclass(frozen=True, eq=False, repr=False)
class Solution(Shown):
    """How a solution ended.

    Attributes:
        residual: largest generalised force left [N m].
        smallest_eigenvalue: of the stiffness matrix (its real part, where loads have no energy) [N m/rad].
        growth: fastest growth of a small disturbance [1/s], negative if all die out (minus infinity where a bound
            proves that, see `stability`); under loads that no energy belongs
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


class Solver:
    """Moves a plant to the equilibrium near its current pose, under a load and the muscles' controls.

    Attributes:
        load: the load on this plant; its `fraction` is what continuation raises.
        extra: generalised forces beside the load [N m], shape (dofs,); 0 unless set.
        forces: generalised forces left at the last pose evaluated [N m], shape (dofs,); zero at rest.
        iterations: evaluations of the stiffness matrix since the last call.
        tolerance: largest generalised force left at rest [N m].
    """

    def __init__(self, plant: Plant, load: Load | None = None) -> None:
        self.plant = plant
        self.load = AppliedLoad(plant, load or Load())
        self.stiffness = TangentStiffness(plant, self.load)
        self._servos = Servos(plant)
        self.scale = plant.springs
        self.tolerance = tolerance(plant.arm)
        self._largest = TOTAL_STEP / plant.arm.links
        self.extra: Array | float = 0.0
        self.forces: Array = np.zeros(plant.model.nv)
        self.iterations = 0
        self.tensions: Array = np.zeros(len(plant.damping))
        self._matrix: Array = np.zeros((0, 0))
        self._unlimited: Array = np.zeros(len(plant.damping))
        self._swing: Swing = (self.forces, 0.0, self.tensions)

    def __call__(self, setpoint: Array) -> float:
        """Settle under set-points [m] or pressures [Pa], shape (M,), going down; return the residual [N m].

        Raises:
            EquilibriumError: no equilibrium near, or only an unstable one; says why.
        """
        self.plant.control[:] = setpoint
        if len(self.plant.pressure):
            self.plant.pressure[:] = setpoint  # the valves have settled too
        self.iterations = 0
        residual, stable = descend(self, self.steps)
        if residual > self.tolerance:
            raise unsettled(self.plant, residual, self.tolerance, self.iterations)
        if not stable:
            raise unstable(self.plant, self.softest())
        return residual

    @property
    def steps(self) -> int:
        """Most steps of a descent, fewer with very many links: seconds in all."""
        return int(STEPS * min(1.0, 300 / self.plant.model.nv))

    def newton(self, iterations: int = ITERATIONS) -> float:
        """Take Newton steps with backtracking; return the residual reached."""
        data, residual = self.plant.data, self._pull()
        for _ in range(iterations):
            if residual <= self.tolerance:
                break
            try:
                step = self.limited(np.linalg.solve(self.tangent(), self.forces))
            except np.linalg.LinAlgError:  # exactly singular
                break
            start, before = data.qpos.copy(), residual
            for _ in range(HALVINGS):
                data.qpos[:] = start + step
                residual = self._pull()
                if residual < before:
                    break
                step *= 0.5
        return residual

    def evaluate(self) -> float:
        """Bring the plant's forces up to date with its pose; return the largest generalised force left [N m]."""
        largest = self._pull()
        self._unlimited, self._swing = self._servos.unlimited(), self.stiffness.swing()
        return largest

    def _pull(self) -> float:
        """Do as `evaluate`, but for what `released` needs."""
        plant = self.plant
        plant.pose()
        self.tensions = plant.muscle_tensions
        plant.tighten(self.tensions)
        self.forces = self.stiffness.forces(self.tensions) + self.extra
        largest = float(np.abs(self.forces).max())
        return largest if np.isfinite(largest) else np.inf

    def tangent(self) -> Array:
        """Return the stiffness matrix at the pose last evaluated [N m/rad], shape (dofs, dofs)."""
        self.iterations += 1
        return self.stiffness.matrix(self.tensions, self.plant.muscle_slopes)

    def softest(self) -> float:
        """Return the smallest eigenvalue of the stiffness matrix at the pose last evaluated [N m/rad]."""
        K = self.stiffness.matrix(self.tensions, self.plant.muscle_slopes)
        return float(np.linalg.eigvalsh(K)[0] if self.stiffness.symmetric else np.linalg.eigvals(K).real.min())

    def solution(self, residual: float) -> Solution:
        """Return what there is to say of the pose last evaluated."""
        return Solution(residual, self.softest(), growth(self), self.iterations)

    def tip_compliance(self) -> Array:
        """Return J K^-1 J^T, shape (6, 6): displacement [m] and rotation [rad] of the tip by force and couple there."""
        J = self.plant.tip_jacobian()
        return J @ np.linalg.solve(self.stiffness.matrix(self.tensions, self.plant.muscle_slopes), J.T)

    def share(self, step: NDArray[np.floating]) -> float:
        """Return what share of a change of joint angles [rad] is not too much at once."""
        return min(1.0, self._largest / max(float(np.abs(step).max()), 1e-300))

    def limited(self, step: NDArray[np.floating]) -> Array:
        """Return a step, shortened if it is longer than a step may be."""
        return np.asarray(step, dtype=float) * self.share(step)

    def positive(self) -> bool:
        """Whether the stiffness matrix at the pose last evaluated is positive: with energy, whether the arm stays."""
        K = self.stiffness.matrix(self.tensions, self.plant.muscle_slopes)
        try:
            np.linalg.cholesky(0.5 * (K + K.T))
        except np.linalg.LinAlgError:
            return False
        return True

    def lifting(self, matrix: Array) -> float:
        """Return a damping that lifts a stiffness matrix's softest mode to as far above zero as it is below."""
        half = np.sqrt(self.scale)
        return max(-2.0 * float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T) / half[:, None] / half)[0]), 1e-9)

    # What `descend` asks for.

    def linearise(self) -> None:
        """Derive the stiffness at the present pose."""
        self._matrix = self.tangent()

    def step(self, damping: float) -> Array | None:
        """Return the change of the joint angles [rad], or None, see `Descent`."""
        K = self._matrix
        if damping:
            K = K.copy()
            K.reshape(-1)[:: len(K) + 1] += damping * self.scale
        try:
            np.linalg.cholesky(K if self.stiffness.symmetric else 0.5 * (K + K.T))
        except np.linalg.LinAlgError:
            return None
        return self.limited(np.linalg.solve(K, self.forces))

    def lift(self) -> float:
        """Return a damping that makes the stiffness positive."""
        return self.lifting(self._matrix)

    def state(self) -> tuple[Any, ...]:
        """Return joint angles [rad], forces [N m], tensions [N], those without limits [N], and of the dead loads."""
        return self.plant.data.qpos.copy(), self.forces, self.tensions, self._unlimited, self._swing

    def restore(self, state: tuple[Any, ...]) -> None:
        """Go back to a state."""
        self.plant.data.qpos[:], self.forces, self.tensions, self._unlimited, self._swing = state

    def move(self, step: Array) -> None:
        """Change the joint angles [rad]."""
        self.plant.data.qpos += step

    def released(self, before: tuple[Any, ...], step: Array) -> tuple[float, float]:
        """Return the energy that a step released and what was expected [J]."""
        _, forces, tensions, unlimited, swing = before
        work = 0.5 * float((forces + self.forces) @ step) - self._servos.kinks(unlimited, self._unlimited)
        work += self.stiffness.work(swing, self._swing, step, 0.5 * (tensions + self.tensions))
        return work, float(0.5 * forces @ step)

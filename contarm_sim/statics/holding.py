"""Poses at rest that meet given muscle lengths, joint angles and tensions found by one Newton.

What a controller that corrects its set-points ends in is an arm whose length differences are met and whose slackest
muscle has its least tension: the lowest energy of all poses with these lengths, tensions being the multipliers. With G
the differences that bends make, and C the same of tensions, but for what leaves the slackest muscle alone,

    K dq + J^T C dT = Q      G J dq = G (wanted - lengths)

solved through K + w (G J)^T G J, which the same step solves and which is positive where the pose is a minimum. The
set-points follow from lengths and tensions.

In an arm of several sections each has a slackest muscle of its own.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.muscles import directions, evenly_spaced
from contarm_sim.mechanics import muscles
from contarm_sim.mechanics.pneumatics import force, passive_slope, passive_tension
from contarm_sim.mechanics.routing import arc_differences
from contarm_sim.mechanics.statics import min_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.statics.descent import descend
from contarm_sim.statics.failures import unsettled, unstable
from contarm_sim.statics.held import Held
from contarm_sim.statics.solver import Solver, tolerance
from contarm_sim.statics.stiffness import TangentStiffness


class Holder(Held):
    """Moves a plant to rest at muscle lengths, from its current pose downhill.

    Args:
        solver: of an arm with three muscles or more in each of its S sections; others are refused by an InputError.

    Attributes:
        extra: generalised forces beside weight and springs [N m], shape (dofs,); 0 unless set.
        least: lowest tension of each muscle's actuator [N], shape (n,); the slackest of each section has it.
        least_pressures: lowest pressures [Pa], shape (n,), where these say what the lowest tensions are; or None.
        tensions: of the actuators, without the silicone's [N], shape (n,).
        iterations: evaluations of the stiffness matrix since the last call.
        tolerance: largest generalised force left at rest [N m].
    """

    def __init__(self, solver: Solver) -> None:
        self.plant = plant = solver.plant
        self._solver = solver
        self._stiffness = TangentStiffness(plant, self._solver.load)
        self.tolerance = tolerance(plant.arm)
        arm = plant.arm
        muscles.require_drivable(arm)
        self._own = muscles.slices(arm)
        self._weight = max(group.servo_stiffness for group in arm.groups)
        self._per_metre = self._weight * max(group.routing.radius for group in arm.groups)
        self.extra: Array | float = 0.0
        self._differences = self._meant = differences(arm)
        self.least = min_tensions(arm)
        self.least_pressures: Array | None = None
        self.tensions = self.least.copy()
        self.wanted = np.zeros(len(self.least))
        self.forces = self._error = np.zeros(0)
        self._lengths = np.zeros(len(self.least))
        self.iterations = 0

    def __call__(self, lengths: Array, meant: Array | None = None) -> None:
        """Come to rest at muscle lengths [m], shape (n,).

        Args:
            meant: what is wanted of them, orthonormal rows, shape (2 S, n); default the differences that bends of the
                arcs make: all but what the lengths of a section's muscles have in common.

        Raises:
            EquilibriumError: no pose at rest was found.
        """
        self.wanted, self.iterations = lengths, 0
        self._meant = self._differences if meant is None else meant
        residual, minimum = descend(self, self._solver.steps)
        if residual > self.tolerance:
            raise unsettled(self.plant, residual, self.tolerance, self.iterations)
        if not minimum:
            raise unstable(self.plant, float(np.linalg.eigvalsh(self._matrix)[0]))

    def by_lengths(self) -> Array:
        """Return the derivative of joint angles by wanted muscle lengths [rad/m], shape (dofs, n)."""
        return np.asarray(self._bent @ np.linalg.solve(self._turned, self._meant))

    def check(self) -> None:
        """Settle under the plant's own controls, which must be set: they hold the pose that was found, and it stays.

        Raises:
            EquilibriumError: they do not, or it would not stay.
        """
        residual = self._solver.evaluate()
        if residual > 100 * self.tolerance:
            raise unsettled(self.plant, residual, self.tolerance, self.iterations)
        if not self._solver.positive():
            raise unstable(self.plant, self._solver.softest())

    # What `descend` asks for.

    def evaluate(self) -> float:
        """Derive forces and lengths; return the largest force left, what a length's error would pull included [N m]."""
        plant = self.plant
        data = plant.data
        data.qvel[:] = 0
        mujoco.mj_kinematics(plant.model, data)
        mujoco.mj_comPos(plant.model, data)
        mujoco.mj_tendon(plant.model, data)
        self._lengths = plant.muscle_lengths
        if self.least_pressures is not None:
            self.least = self.least_pressures * force(1.0, self._lengths, plant.arm)
        self._total = self.tensions + passive_tension(self._lengths, plant.arm)
        plant.tighten(self._total)
        self.forces = self._stiffness.forces(self._total) + self.extra
        self._swing = self._stiffness.swing()
        self._error = self._meant @ (self.wanted - self._lengths)
        largest = max(float(np.abs(self.forces).max()), self._per_metre * float(np.abs(self._error).max()))
        return largest if np.isfinite(largest) else np.inf

    def linearise(self) -> None:
        """Derive the stiffness, and what tensions and lengths have to do with joint angles."""
        self.iterations += 1
        plant = self.plant
        K = self._stiffness.matrix(self._total, passive_slope(self._lengths, plant.arm))
        J = plant.muscle_jacobian
        self._by_length = self._meant @ J
        self._free = self._meant.T.copy()
        for own in self._own:
            slackest = own.start + int(np.argmax((self.least - self.tensions)[own]))
            self._free[own] -= self._meant[:, slackest]
        self._by_tension = (J + plant.twist_by_tension).T @ self._free
        weight = self._weight
        self._matrix = K + weight * self._by_length.T @ self._by_length
        self._rest = np.column_stack([self.forces + weight * self._error @ self._by_length, self._by_tension])

    def step(self, damping: float) -> Array | None:
        """Return the change of joint angles [rad] and tensions [N], or None, see `Descent`."""
        K = self._matrix
        if damping:
            K = K.copy()
            K.reshape(-1)[:: len(K) + 1] += damping * self._solver.scale
        try:
            np.linalg.cholesky(K)
        except np.linalg.LinAlgError:
            return None
        solved = np.linalg.solve(K, self._rest)
        bent, free = solved[:, 1:], solved[:, 0]
        turned = self._by_length @ bent
        pull = np.linalg.solve(turned, self._by_length @ free - self._error)
        step = free - bent @ pull
        share = self._solver.share(step)
        self._bent, self._turned = bent, turned
        return np.concatenate([share * step, share * (self._free @ pull)])

    def lift(self) -> float:
        """Return a damping that lifts the softest mode to as far above zero as it is below."""
        return self._solver.lifting(self._matrix)

    def state(self) -> tuple[Any, ...]:
        """Return joint angles [rad], forces [N m], tensions [N], errors of length [m], and of the dead loads."""
        return self.plant.data.qpos.copy(), self.forces, self.tensions, self._error, self._swing

    def restore(self, state: tuple[Any, ...]) -> None:
        """Go back to a state."""
        self.plant.data.qpos[:], self.forces, self.tensions, self._error, self._swing = state

    def move(self, step: Array) -> None:
        """Change joint angles [rad] and tensions [N]; the slackest muscle has the least."""
        dofs = len(self.plant.data.qpos)
        self.plant.data.qpos += step[:dofs]
        tensions = self.tensions + step[dofs:]
        for own in self._own:
            tensions[own] += (self.least - tensions)[own].max()
        self.tensions = tensions

    def released(self, before: tuple[Any, ...], step: Array) -> tuple[float, float]:
        """Return the energy that a step released and what was expected [J]; lengths that are met do no work."""
        _, forces, tensions, error, swing = before
        weight, turn = 0.5 * self._weight, step[: len(forces)]
        sought = weight * float(error @ error)
        work = 0.5 * float((forces + self.forces) @ turn) + sought - weight * float(self._error @ self._error)
        work += self._stiffness.work(swing, self._swing, turn, 0.5 * (tensions + self.tensions))
        return work, float(0.5 * forces @ turn) + sought


def differences(arm: Arm) -> Array:
    """Return what bends of the arcs change of muscle lengths, as orthonormal rows, shape (2 S, n).

    What the lengths of a section's muscles have in common is none of it.
    """
    if len(arm.sections) == 1 and evenly_spaced(arm.routing.angles):
        return np.asarray(np.sqrt(2 / len(arm.routing.angles)) * directions(arm.routing.angles).T)
    return np.asarray(np.linalg.qr(arc_differences(arm))[0].T)

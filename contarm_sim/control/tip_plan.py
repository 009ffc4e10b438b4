"""Set-points that bring the model's own tip to its targets: statics and dynamics of the whole chain, inverted.

Muscle lengths steer two of the tip's three coordinates, so each sample is a small least-squares problem: the bend whose
muscle lengths let the tip, at rest under gravity and load, come nearest to its target. Gauss-Newton solves it, damped
where that leads away, with the derivative of the resting tip by lengths that the last step of `holding` has found. In
motion the same problem is solved again with what the planned joint angles take to move, inertia and damping, as forces
on the resting arm (d'Alembert).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.errors import EquilibriumError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.routing import length_jacobian, lengths_from_bend
from contarm_sim.mechanics.statics import min_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.statics.holding import Holder
from contarm_sim.statics.solver import Solver

STEP = 1e-7
"""Change of the bend at which a sample has converged [rad]."""

LONGEST = 0.2
"""Largest change of the bend at once [rad]."""

LARGEST = 0.98 * np.pi
"""Largest bend that is tried [rad]."""

ITERATIONS = 60
"""Most steps for one sample, those taken back included; a handful do."""


KEPT = 1e-3
"""What 1 rad off the bends asked for counts as, beside a tip that is off its target [lengths].

Several sections have more bends than a tip has coordinates, and straight ones move it in no length: there they stay as
asked. Elsewhere it takes a millionth of the correction.
"""


LEAST_DAMPING, FLOOR = 1e-2, 1e-12
"""Least damping after a step that was taken back, and what there is always, over the trace of what is solved."""

NEARER = 1e-9
"""Farther than this [lengths], a tip is no nearer to its target."""

FAINT = 1e-8
"""Of what a step has shown of the second derivative, what counts as nothing."""


def eased(damping: Any) -> Any:
    """Return the damping after a step that was taken."""
    return np.where(damping > 1e-3, 0.2 * damping, 0.0)


def raised(damping: Any) -> Any:
    """Return the damping after a step that was taken back."""
    return np.maximum(4 * damping, LEAST_DAMPING)


class TipPlan:
    """Finds set-points for one arm, sample by sample.

    Attributes:
        plant: the arm, at rest in the last sample solved.
    """

    def __init__(self, arm: Arm) -> None:
        self.plant = Plant(arm)
        self._holder = Holder(Solver(self.plant))
        self._keep = 0.0 if len(arm.sections) == 1 else (KEPT * arm.length) ** 2

    def solve(
        self, bend: Array, target: Array, forces: Array | float = 0.0, least: Array | None = None, checked: bool = True
    ) -> tuple[Array, Array]:
        """Bring the tip from its current pose as near to a target [m], shape (3,), as it gets.

        Args:
            bend: about where that is [rad], shape (2 S,): what the plan falls back to.
            forces: generalised forces on the joints [N m], shape (dofs,).
            least: tensions that the muscles keep at least [N], shape (n,); default the arm's least.
            checked: refuse set-points that servos at rest cannot follow.

        Returns:
            the set-points [m], shape (n,), and the derivative of the tip by the bend asked for [m/rad], shape (3, 2 S).

        Raises:
            EquilibriumError: there is no pose at rest at this bend; says why.
        """
        holder, data = self._holder, self.plant.data
        holder.extra = forces
        holder.least = min_tensions(self.plant.arm) if least is None else least
        holder.tensions = holder.least.copy()
        asked, bend, damping = bend, bend.copy(), 0.0
        holder(lengths_from_bend(bend, self.plant.arm))
        slope, off, curved = self._slope(bend), target - self.plant.tip, np.zeros((len(bend), len(bend)))
        excess = holder.excess()
        for _ in range(ITERATIONS):
            gram = slope.T @ slope + curved + self._keep * np.eye(len(bend))
            pull = slope.T @ off + self._keep * (asked - bend)
            change = np.linalg.solve(gram + (damping + FLOOR) * np.trace(gram) * np.eye(len(bend)), pull)
            size = float(np.linalg.norm(change))
            if size <= STEP:
                break
            change *= min(1.0, LONGEST / size)
            before = data.qpos.copy(), holder.tensions, slope
            cost = float(off @ off) + self._keep * float(np.square(bend - asked).sum())
            if self._nearer(bend + change, asked, target, cost, excess):
                bend, damping = bend + change, float(eased(damping))
                slope, off, excess = self._slope(bend), target - self.plant.tip, holder.excess()
                curved = _curved(curved, change, (before[2] - slope).T @ off, slope)
            else:
                data.qpos[:], holder.tensions = before[:2]
                damping, curved = float(raised(damping)), np.zeros((len(bend), len(bend)))
        holder(lengths_from_bend(bend, self.plant.arm))
        return holder.setpoints(checked), slope

    def _nearer(self, bend: Array, asked: Array, target: Array, cost: float, excess: float) -> bool:
        """Whether the tip, at rest at a bend, is no farther from its target than before, and as well held."""
        if np.hypot(bend[::2], bend[1::2]).max() > LARGEST:
            return False
        try:
            self._holder(lengths_from_bend(bend, self.plant.arm))
        except EquilibriumError:
            return False
        off = target - self.plant.tip
        far = float(off @ off) + self._keep * float(np.square(bend - asked).sum())
        near = far <= cost + (NEARER * self.plant.arm.length) ** 2
        return bool(near and self._holder.excess() <= excess)

    def _slope(self, bend: Array) -> Array:
        """Return the derivative of the resting tip by the bend whose lengths it has [m/rad], shape (3, 2 S)."""
        J = self.plant.tip_jacobian()[:3]
        return J @ self._holder.by_lengths() @ length_jacobian(bend, self.plant.arm)


def _curved(curved: Array, change: Array, turned: Array, slope: Array) -> Array:
    """Return what the tip's second derivative adds to slope^T slope, shape (2, 2), from what one step has shown.

    Targets off the surface of resting tips make Gauss-Newton slow without it. Symmetric rank one; nothing where the sum
    would not be positive.
    """
    miss = turned - curved @ change
    along = float(miss @ change)
    if abs(along) > FAINT * float(np.linalg.norm(miss) * np.linalg.norm(change)):
        curved = curved + np.outer(miss, miss) / along
    total = slope.T @ slope + curved
    if len(total) > 2:  # a Jacobian of three rows leaves directions that only the damping holds
        return np.zeros_like(curved)
    positive = total[0, 0] > 0 and total[0, 0] * total[1, 1] > 1.01 * total[0, 1] * total[1, 0]
    return curved if positive else np.zeros((2, 2))

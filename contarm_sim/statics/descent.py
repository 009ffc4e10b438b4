"""Downhill to a stable pose: damped Newton on a potential, which from any start ends in one of its minima.

A step solves (K + damping diag(k)) dq = Q. It is taken where it releases energy, found from the forces at both ends;
else it is damped more. Where the stiffness has negative eigenvalues the damping is what lifts them: an arm that would
not stay where Newton alone takes it falls further instead.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from contarm_sim.kinematics.arrays import Array

STEPS = 1000
"""Most steps, those taken back included; a handful do, hundreds for chains that weigh a thousand stiffnesses."""

DAMPED = 0.01
"""Least damping after a step that was taken back [joint stiffnesses]."""


SHARE, LEFT = 0.05, 0.5
"""A step is taken that releases this share of the energy expected, or, undamped, leaves this share of the force."""


class Descent(Protocol):
    """Where `descend` goes down.

    Attributes:
        tolerance: largest generalised force at rest [N m].
    """

    tolerance: float

    def evaluate(self) -> float:
        """Derive the forces at the present state; return the largest left [N m]."""

    def linearise(self) -> None:
        """Derive the stiffness at the present state."""

    def step(self, damping: float) -> Array | None:
        """Return the step under a damping [joint stiffnesses]; None where the damped stiffness is not positive."""

    def lift(self) -> float:
        """Return the damping [joint stiffnesses] that makes the stiffness positive with a margin."""

    def state(self) -> tuple[Any, ...]:
        """Return copies of what `restore` needs."""

    def restore(self, state: tuple[Any, ...]) -> None:
        """Go back to a state; forces and stiffness are those of it again."""

    def move(self, step: Array) -> None:
        """Change the unknowns."""

    def released(self, before: tuple[Any, ...], step: Array) -> tuple[float, float]:
        """Return the energy that a step taken since a state released, and what was expected of it [J]."""


def descend(problem: Descent, steps: int = STEPS) -> tuple[float, bool]:
    """Go down to rest; return the largest force left [N m] and whether the pose is a minimum.

    A pose at rest that is none is a saddle, met only where forces have no part along its way down.
    """
    residual, damping = problem.evaluate(), 0.0
    problem.linearise()
    for _ in range(steps):
        step = problem.step(damping)
        if residual <= problem.tolerance and damping == 0.0:
            return residual, step is not None
        if step is None:
            if residual <= problem.tolerance:
                return residual, False
            damping = max(2 * damping, problem.lift())
            continue
        before = problem.state()
        problem.move(step)
        now = problem.evaluate()
        gain, expected = problem.released(before, step)
        if np.isfinite(now) and (gain > SHARE * expected or (damping == 0.0 and now <= LEFT * residual)):
            residual = now
            damping = 0.2 * damping if gain > 0.5 * expected else damping
            damping = 0.0 if damping < 0.1 * DAMPED or residual <= problem.tolerance else damping
            problem.linearise()
        else:
            problem.restore(before)
            damping = max(4 * damping, DAMPED)
            if damping > 1e12:
                break
    return residual, False

"""Why an arm has no pose at rest, in one line that says what would help."""

from __future__ import annotations

import math

from contarm_sim.arm import Arm
from contarm_sim.errors import ConvergenceError


def unstable(arm: Arm, softest: float, residual: float, allowed: float, iterations: int) -> ConvergenceError:
    """Return the error of an arm whose only pose found would not stay: its softest mode is below 0 [N m/rad]."""
    weight = (arm.mass + arm.payload) * math.hypot(*arm.gravity) * arm.length**2 / arm.bending_stiffness
    return ConvergenceError(
        f"settling found only an unstable pose (softest mode {softest:.3g} N m/rad; weight times length^2 over EI is "
        f"{weight:.3g}, which buckles an upright arm from 7.84 on; a stiffer or lighter arm stands) and",
        residual, allowed, iterations, "N m",
    )  # fmt: skip

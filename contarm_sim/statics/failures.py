"""Why an arm has no pose at rest, in one line that says what would help."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import NoEquilibriumError, NotConvergedError, UnstableError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf.names import joints
from contarm_sim.model.arm import Arm

if TYPE_CHECKING:
    from contarm_sim.engine.index import ArmIndex
    from contarm_sim.engine.plant import Plant

BUCKLING = 7.84
"""Weight times length^2 over EI from which on an upright arm without payload buckles (Greenhill)."""

AT_TIP = 3.18
"""What a mass at the tip counts more than one that is spread evenly: BUCKLING over (pi/2)^2 (Euler)."""


def heaviness(arm: Arm) -> float:
    """Return weight times length^2 over EI, a payload counted as it counts for buckling, see `BUCKLING`.

    Of several sections, length/EI is the sum of theirs.
    """
    mass = arm.mass + AT_TIP * arm.payload
    softness = sum(section.length / section.bending_stiffness for section in arm.sections)
    return mass * math.hypot(*arm.gravity) * arm.length * softness


def _said(arm: Arm) -> str:
    return f"(m + {AT_TIP} payload) g L^2/EI" if arm.payload else "m g L^2/EI"


def unstable(plant: Plant, softest: float) -> UnstableError:
    """Return the error of an arm whose only pose found would not stay: its softest mode is below 0 [N m/rad]."""
    arm = plant.arm
    weight, found = heaviness(arm), f"an unstable one alone (softest mode {softest:.3g} N m/rad)"
    if weight <= BUCKLING:
        reason = f"{found}; less load or tension would help"
    elif arm.gravity[2] < 0:
        reason = (
            f"{found}, the arm buckles under its own weight: {_said(arm)} is {weight:.3g}, upright it carries "
            f"{BUCKLING}; a stiffer, shorter or lighter arm stands"
        )
    else:  # no part of the weight presses on the straight arm
        reason = f"{found}; {_said(arm)} is {weight:.3g}: a stiffer, shorter or lighter arm, or less bend, would help"
    return UnstableError(reason, softest, 0.0, pose=plant.data.qpos.copy(), residual=0.0)


def unsettled(
    plant: Plant, residual: float, allowed: float, iterations: int, fraction: float = 1.0
) -> NotConvergedError:
    """Return the error of an arm that did not come to rest within the steps allowed, under a share of its load."""
    arm = plant.arm
    reached = "" if fraction == 1.0 else f" at {100 * fraction:.3g} % of the load"
    return NotConvergedError(
        f"the search ended after {iterations} steps with {residual:.3g} N m left{reached} (allowed: {allowed:.2g}); "
        f"{_said(arm)} is {heaviness(arm):.3g}, {arm.links} links; less load, a stiffer arm, or a guess nearer to the "
        "pose would help",
        residual,
        allowed,
        pose=plant.data.qpos.copy(),
        load_fraction=fraction,
        residual=residual,
    )


FOLD = 0.5 * math.pi
"""Most that a joint may bend by [rad].

A chain of 2 links, the fewest there may be, bends by as much in a half turn, the largest bend. Links that fold further
are no backbone any more. The converged poses of elastica, also in chains of 12 links, take 0.5 rad at most.
"""


def impossible(arm: Arm, angles: Array, lengths: Array) -> None:
    """Check that an arm can take a pose, of joint angles [rad], shape (dofs,), and muscle lengths [m], shape (M,).

    Raises:
        NoEquilibriumError: a joint is folded, see `FOLD`, or a muscle has no length left.
    """
    squares = np.zeros(arm.links + 1)
    for hinge, angle in zip(joints(arm), angles.tolist(), strict=True):
        squares[hinge.station] += angle**2 if hinge.axis != "z" else 0.0
    bend, shortest = math.sqrt(squares.max()), float(lengths.min(initial=math.inf))
    if bend > FOLD:
        raise NoEquilibriumError(
            f"joint {squares.argmax()} would bend by {math.degrees(bend):.4g} deg, the most is "
            f"{math.degrees(FOLD):.0f} deg; less load, a stiffer arm or more links would help",
            bend,
            FOLD,
            pose=angles.copy(),
            residual=0.0,
        )
    if shortest <= 0:
        raise NoEquilibriumError(
            f"a muscle would have a length of {1e3 * shortest:.4g} mm; less load, a stiffer arm or a smaller muscle "
            "radius would help",
            shortest,
            0.0,
            pose=angles.copy(),
            residual=0.0,
        )


def possible(index: ArmIndex, angles: Array, lengths: Array) -> NDArray[np.bool_]:
    """Return whether arms can take poses, shape (C,), of joint angles [rad] and muscle lengths [m], as `impossible`."""
    squares = np.square(angles[:, index.bending["x"]]) + np.square(angles[:, index.bending["y"]])
    return (np.sqrt(squares.max(axis=-1)) <= FOLD) & (lengths.min(axis=-1, initial=np.inf) > 0)


def too_strong(name: str, limit: float, needed: float) -> NoEquilibriumError:
    """Return the error of a pose that takes a larger tension [N] than muscles have."""
    return NoEquilibriumError(
        f"{name} is at its limit of {limit:.0f} N and would need {needed:.4g} N; bend or carry less, or take a "
        "larger muscle radius, thicker muscles or more pressure",
        needed,
        limit,
    )


def too_short(name: str, low: float, high: float, control: float) -> NoEquilibriumError:
    """Return the error of a pose whose set-point [m] is out of its range."""
    return NoEquilibriumError(
        f"{name} would need a set-point of {1e3 * control:.4g} mm, out of {1e3 * low:.4g} to {1e3 * high:.4g} mm; "
        "bend less, or take a smaller muscle radius",
        control,
        high if control > high else low,
    )


def too_much_pressure(name: str, limit: float, needed: float) -> NoEquilibriumError:
    """Return the error of a pose that takes more pressure [Pa] than there is."""
    said = f"would need {1e-3 * needed:.4g} kPa" if math.isfinite(needed) else "is too short to pull at any pressure"
    return NoEquilibriumError(
        f"{name} {said}, the most is {1e-3 * limit:.4g} kPa; bend or carry less, or take a larger muscle radius, "
        "thicker muscles or more pressure",
        needed,
        limit,
    )

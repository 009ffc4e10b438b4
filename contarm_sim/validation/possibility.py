"""The pressure-limited possibility map: which bends pressures hold, and whether the simulated arm agrees."""

from __future__ import annotations

import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import ConvergenceError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.load import Load, Muscles
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.statics import holding_pressures, pressure_needed
from contarm_sim.simulation.equilibrium import equilibrium

_ANGLES = np.radians(np.arange(0, 180, 0.25))


def largest_bends(arm: Arm, planes: Array) -> tuple[Array, Array]:
    """Return the largest bend angles [rad] towards planes [rad], shape (P,): all muscles inflated, one may be vented.

    0 where pressures hold not even a small bend; to a quarter of a degree, interpolated between.
    """
    needs = pressure_needed(arc.from_polar(_ANGLES[:, None], planes), arm)
    return _largest(needs[0], arm), _largest(needs[1], arm)


def _largest(need: Array, arm: Arm) -> Array:
    limit = arm.muscle.max_pressure
    held = need <= limit
    last = len(_ANGLES) - 1 - held[::-1].argmax(axis=0)  # of those that are held
    found = _ANGLES[last]
    for j in np.flatnonzero(held.any(axis=0) & (last < len(_ANGLES) - 1)):
        below, above = need[last[j], j], need[last[j] + 1, j]
        if np.isfinite(above) and above > below:
            found[j] += (_ANGLES[1] - _ANGLES[0]) * (limit - below) / (above - below)
    return np.where(held.any(axis=0), found, 0.0)


def held_off(arm: Arm, bend_angle: float, plane_angle: float) -> float | None:
    """Hold a bend [rad] by its closed-form pressures in the simulated arm.

    Returns:
        how far the bend that its muscle lengths show is off [rad]; None if it rests nowhere near.
    """
    bend = arc.from_polar(bend_angle, plane_angle)
    muscles = Muscles(kind="pressures", values=tuple(holding_pressures(bend, arm)))
    try:
        found = equilibrium(arm, Load(muscles=muscles))
    except ConvergenceError:
        return None
    measured, _ = routing.bend_from_lengths(found.muscle_lengths, arm)
    return float(np.hypot(*(measured - bend)))

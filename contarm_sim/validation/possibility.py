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

COARSE, FINE = np.radians(1.0), np.radians(0.25)
"""Steps in which bend angles are tried [rad]: all of them coarsely, those after the largest that is held finely."""

_ANGLES = np.arange(0, np.pi - 0.5 * COARSE, COARSE)
_LAST = np.pi - FINE


def largest_bends(arm: Arm, planes: Array) -> tuple[Array, Array]:
    """Return the largest bend angles [rad] towards planes [rad], shape (P,): all muscles inflated, one may be vented.

    0 where pressures hold not even a small bend; to a quarter of a degree, interpolated between.
    """
    inflated, vented = pressure_needed(arc.from_polar(_ANGLES[:, None], planes), arm)
    return _largest(inflated, 0, arm, planes), _largest(vented, 1, arm, planes)


def _largest(needed: Array, which: int, arm: Arm, planes: Array) -> Array:
    """Return the largest angles [rad], shape (P,), of pressures needed [Pa], shape (angles, P), of one of two kinds."""
    limit = arm.muscle.max_pressure
    held = needed <= limit
    last = len(_ANGLES) - 1 - held[::-1].argmax(axis=0)  # of those that are held
    angles = np.minimum(_ANGLES[last] + FINE * np.arange(round(COARSE / FINE) + 1)[:, None], _LAST)
    need = pressure_needed(arc.from_polar(angles, planes), arm)[which]
    end = len(angles) - 1
    last = end - (need <= limit)[::-1].argmax(axis=0)
    found = np.take_along_axis(angles, last[None], 0)[0]
    for j in np.flatnonzero(held.any(axis=0) & (last < end)):
        below, above = need[last[j], j], need[last[j] + 1, j]
        if np.isfinite(above) and above > below:
            found[j] += FINE * (limit - below) / (above - below)
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

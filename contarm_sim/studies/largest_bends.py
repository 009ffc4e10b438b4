"""The pressure-limited possibility map: which bends pressures hold, and whether the simulated arm agrees."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contarm_sim.errors import EquilibriumError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.pressures import pressure_needed
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.studies.balance_at_rest import RestingBalance

COARSE, FINE = np.radians(1.0), np.radians(0.25)
"""Steps in which bend angles are tried [rad]: all of them coarsely, those after the largest that is held finely."""

_ANGLES = np.arange(0, np.pi - 0.5 * COARSE, COARSE)
_LAST = float(np.pi - FINE)

_STEP = np.radians(2.0)
"""Between bends that are tried to find a largest one's neighbourhood."""

_CLOSE = 3e-4
"""To what largest bends of the simulated arm are found [rad]."""


def largest_bends(arm: Arm, planes: Array) -> tuple[Array, Array]:
    """Return the largest bend angles [rad] towards planes [rad], shape (P,): all muscles inflated, one may be vented.

    0 where pressures hold not even a small bend; to a quarter of a degree, interpolated between. In closed form:
    exact without gravity (0.1 deg); under gravity the arm is taken to bend evenly, which is off by 1 deg under the
    default arm's weight, by 2.5 deg with 100 g at its tip. `largest_bends_at_rest` knows better.
    """
    inflated, vented = pressure_needed(arc.from_polar(_ANGLES[:, None], planes), arm)
    return _largest(inflated, 0, arm, planes), _largest(vented, 1, arm, planes)


def _largest(needed: Array, which: int, arm: Arm, planes: Array) -> Array:
    """Return the largest angles [rad], shape (P,), of pressures needed [Pa], shape (angles, P), of one of two kinds."""
    limit = arm.pneumatics.max_pressure
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


def largest_bends_at_rest(arm: Arm, planes: Array) -> tuple[Array, Array]:
    """Return what `largest_bends` does, by the statics of the simulated arm, which sags: some 100 ms a plane.

    With 24 links it is within 0.15 deg of the ideal rod. Bends are tried outwards or inwards from the closed form's, so
    they are the limits next to those; without gravity they are those.
    """
    found = np.array(largest_bends(arm, planes))
    if not any(arm.gravity):
        return found[0], found[1]
    for i, plane in enumerate(planes):
        resting = RestingBalance(arm)
        for which in range(2):

            def room(
                angle: float, which: int = which, plane: float = plane, resting: RestingBalance = resting
            ) -> float:
                return arm.pneumatics.max_pressure / resting.needed(arc.from_polar(angle, plane))[which] - 1

            found[which, i] = _limit(room, float(found[which, i]))
    return found[0], found[1]


def fallen_from(arm: Arm, largest: float) -> list[float]:
    """Return which of some bend angles [rad] towards muscle 1 pressures do not hold, though they hold larger ones.

    An arm that stands under too much weight falls over before it is bent far enough to be held again.
    """
    resting, limit = RestingBalance(arm), arm.pneumatics.max_pressure
    angles = [angle for angle in np.radians([1, 15, 30, 45, 60, 90, 120, 150]).tolist() if angle < largest]
    return [angle for angle in angles if not resting.needed(arc.from_polar(angle, 0.0))[1] <= limit]


def every_bend(arm: Arm) -> float:
    """Return the largest bend angle [rad] up to which pressures hold the arm at rest in every plane, all inflated."""
    planes = np.radians(np.arange(360))
    closed, _ = largest_bends(arm, planes)
    weakest = planes[(closed <= np.roll(closed, 1)) & (closed < np.roll(closed, -1))]
    return float(min(closed)) if len(weakest) == 0 else float(min(largest_bends_at_rest(arm, weakest)[0]))


def _limit(room: Callable[[float], float], angle: float) -> float:
    """Return the angle near a guess [rad] where `room` falls to zero, 0 or the largest one tried if it does not."""
    from scipy.optimize import brentq

    end = _LAST
    if room(angle) >= 0:
        while angle < end and room(min(angle + _STEP, end)) >= 0:
            angle = min(angle + _STEP, end)
        return float(brentq(room, angle, min(angle + _STEP, end), xtol=_CLOSE)) if angle < end else end
    while angle > 0 and room(max(angle - _STEP, 0.0)) < 0:
        angle = max(angle - _STEP, 0.0)
    return float(brentq(room, max(angle - _STEP, 0.0), angle, xtol=_CLOSE)) if angle > 0 else 0.0


def held_off(arm: Arm, bend_angle: float, plane_angle: float) -> float | None:
    """Hold a bend [rad] by the pressures that the simulated arm's statics ask for, at constant pressures.

    Returns:
        how far the bend that its muscle lengths show is off [rad]; None if it rests nowhere near.
    """
    bend = arc.from_polar(bend_angle, plane_angle)
    try:
        pressures = RestingBalance(arm).pressures(bend)
        found = equilibrium(arm, Load(muscles=Muscles(kind="pressures", values=tuple(pressures))))
    except EquilibriumError:
        return None
    measured, _ = routing.bend_from_lengths(found.muscle_lengths, arm)
    return float(np.hypot(*(measured - bend)))

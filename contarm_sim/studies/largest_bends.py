"""The pressure-limited possibility map: which bends pressures hold, and whether the simulated arm agrees."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contarm_sim.errors import EquilibriumError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing, shape
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.studies.balance_at_rest import RestingBalance
from contarm_sim.studies.needs import most, needs_of

COARSE, FINE = np.radians(1.0), np.radians(0.25)
"""Steps in which bend angles are tried [rad]: all of them coarsely, those after the largest that is held finely."""

_ANGLES = np.arange(0, np.pi - 0.5 * COARSE, COARSE)
_LAST = float(np.pi - FINE)

_STEP = np.radians(2.0)
"""Between bends that are tried to find a largest one's neighbourhood."""

PLANES_AT_ONCE = 24
"""Planes whose bends are balanced together: what is in memory stays small."""

_CLOSE = 3e-4
"""To what largest bends of the simulated arm are found [rad]."""


def posed(arm: Arm, angle: Any, plane: Any, section: int = 0, others: Array | None = None) -> Array:
    """Return the coordinates [rad], shape (..., 2 S), of a section's bend angle and plane [rad], which broadcast.

    Args:
        section: its number, from 0.
        others: coordinates of a pose that the other sections are in [rad], shape (2 S,); default straight.
    """
    bend = arc.from_polar(angle, plane)
    if len(arm.sections) == 1:
        return bend
    out = np.zeros((*bend.shape[:-1], 2 * len(arm.sections)))
    out[...] = 0.0 if others is None else others
    out[..., 2 * section : 2 * section + 2] = bend
    return out


def largest_bends(arm: Arm, planes: Array, section: int = 0, others: Array | None = None) -> tuple[Array, Array]:
    """Return the largest bend angles [rad] towards planes [rad], shape (P,): all muscles inflated, one may be vented.

    0 where pressures hold not even a small bend; to a quarter of a degree, interpolated between. In closed form:
    exact without gravity (0.1 deg); under gravity the arm is taken to bend evenly, which is off by 1 deg under the
    default arm's weight, by 2.5 deg with 100 g at its tip. `largest_bends_at_rest` knows better.

    Args:
        section, others: of several sections the one that bends, and the pose of the others, see `posed`. All muscles of
            the arm count, not its own alone.
    """
    needed = [np.empty((len(_ANGLES), len(planes))) for _ in range(2)]
    for first in range(0, len(planes), PLANES_AT_ONCE):
        some = slice(first, first + PLANES_AT_ONCE)
        both = needs_of(posed(arm, _ANGLES[:, None], planes[some], section, others), arm)
        for kind, need in zip(needed, both, strict=True):
            kind[:, some] = need
    inflated, vented = (_largest(need, i, arm, planes, section, others) for i, need in enumerate(needed))
    return inflated, vented


def _largest(needed: Array, which: int, arm: Arm, planes: Array, section: int, others: Array | None) -> Array:
    """Return the largest angles [rad], shape (P,), of what is needed, shape (angles, P), of one of two kinds."""
    limit = most(arm)
    held = needed <= limit
    last = len(_ANGLES) - 1 - held[::-1].argmax(axis=0)  # of those that are held
    angles = np.minimum(_ANGLES[last] + FINE * np.arange(round(COARSE / FINE) + 1)[:, None], _LAST)
    need = needs_of(posed(arm, angles, planes, section, others), arm)[which]
    end = len(angles) - 1
    last = end - (need <= limit)[::-1].argmax(axis=0)
    found = np.take_along_axis(angles, last[None], 0)[0]
    for j in np.flatnonzero(held.any(axis=0) & (last < end)):
        below, above = need[last[j], j], need[last[j] + 1, j]
        if np.isfinite(above) and above > below:
            found[j] += FINE * (limit - below) / (above - below)
    return np.where(held.any(axis=0), found, 0.0)


def largest_bends_at_rest(
    arm: Arm, planes: Array, section: int = 0, others: Array | None = None
) -> tuple[Array, Array]:
    """Return what `largest_bends` does, by the statics of the simulated arm, which sags: some 100 ms a plane.

    With 24 links it is within 0.15 deg of the ideal rod. Bends are tried outwards or inwards from the closed form's, so
    they are the limits next to those; without gravity they are those.
    """
    found = np.array(largest_bends(arm, planes, section, others))
    if not any(arm.gravity):
        return found[0], found[1]
    for i, plane in enumerate(planes):
        resting = RestingBalance(arm)
        for which in range(2):

            def room(
                angle: float, which: int = which, plane: float = plane, resting: RestingBalance = resting
            ) -> float:
                return most(arm) / resting.needed(posed(arm, angle, plane, section, others))[which] - 1

            found[which, i] = _limit(room, float(found[which, i]))
    return found[0], found[1]


def fallen_from(arm: Arm, largest: float, section: int = 0, others: Array | None = None) -> list[float]:
    """Return which of some bend angles [rad] towards the section's muscle 1 are not held, though larger ones are.

    An arm that stands under too much weight falls over before it is bent far enough to be held again.
    """
    resting, limit = RestingBalance(arm), most(arm)
    plane = arm.routings[section].angles[0]
    angles = [angle for angle in np.radians([1, 15, 30, 45, 60, 90, 120, 150]).tolist() if angle < largest]
    return [x for x in angles if not resting.needed(posed(arm, x, plane, section, others))[1] <= limit]


def every_bend(arm: Arm, section: int = 0, others: Array | None = None) -> float:
    """Return the largest bend angle [rad] up to which pressures hold the arm at rest in every plane, all inflated."""
    planes = np.radians(np.arange(360) if len(arm.sections) == 1 else np.arange(0, 360, 5))
    closed, _ = largest_bends(arm, planes, section, others)
    weakest = planes[(closed <= np.roll(closed, 1)) & (closed < np.roll(closed, -1))]
    if len(weakest) == 0:  # all planes alike, as one uniform bend sees them
        if not any(arm.gravity):
            return float(min(closed))
        weakest = planes[:: len(planes) // 8]
    return float(min(largest_bends_at_rest(arm, weakest, section, others)[0]))


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


def held_off(arm: Arm, bend: Array) -> float | None:
    """Hold a bend [rad], shape (2 S,), by what the simulated arm's statics ask for, at constant pressures or tensions.

    Returns:
        how far the bend that its muscle lengths show is off [rad], of several sections that of the worst; None if it
        rests nowhere near.
    """
    try:
        found = equilibrium(arm, Load(muscles=RestingBalance(arm).drive(bend)))
    except EquilibriumError:
        return None
    measured, _ = routing.bend_from_lengths(found.muscle_lengths, arm)
    off = shape.bends_of(measured - bend, arm)
    return float(np.hypot(off[:, 0], off[:, 1]).max())

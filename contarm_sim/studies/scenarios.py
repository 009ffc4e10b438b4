"""The loads that an arm is studied under, and the scenarios that it is validated in."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from contarm_sim.control.registry import ControllerName
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.results.summary import ErrorSummary, Spread
from contarm_sim.studies.checks import ideal_checks, loaded_checks
from contarm_sim.studies.explained import RodParts
from contarm_sim.studies.verdict import Check

HANGING = (0.0, 0.0, 9.81)
UPRIGHT = (0.0, 0.0, -9.81)
PAYLOAD = 0.1

Checks = Callable[[Arm, ErrorSummary, RodParts, Spread], list[Check]]
"""Of the arm, its errors, what the rod explains of them, and the distance from the chain's closed form."""


@dataclass(frozen=True)
class Scenario:
    """One arm under one load, driven one way.

    Attributes:
        name: what it is called in summaries.
        meaning: what it shows, in a few words.
        arm: with this scenario's gravity and payload.
        controller: how lengths and set-points are found.
        checks: what is checked of it; None: not judged.
    """

    name: str
    meaning: str
    arm: Arm
    controller: ControllerName
    checks: Checks | None


def dome_grid(grid: int, max_bend: float = LARGEST_BEND) -> Array:
    """Return bends [rad] over the dome, shape (3 grid^2 + 1, 2).

    Straight, then `grid` angles to `max_bend` [rad] by 3 `grid` planes.
    """
    angles = max_bend * np.arange(1, grid + 1) / grid
    planes = 2 * np.pi * np.arange(3 * grid) / (3 * grid)
    bends = arc.from_polar(angles[:, None], planes)
    return np.concatenate([np.zeros((1, 2)), bends.reshape(-1, 2)])


EXTREMES = 8
"""Poses of `spread_bends` in which every section bends as far as it may."""


def spread_bends(arm: Arm, poses: int, max_bend: float) -> Array:
    """Return bends of all sections [rad], shape (T, 2 S), that fill what there is evenly, the straight pose first.

    Sobol's points: T is the power of two that follows `poses`, and `EXTREMES` more, in which all sections bend by
    `max_bend` [rad], each in a plane turned by one angle from that of the section before it.
    """
    from scipy.stats import qmc

    count = len(arm.sections)
    points = qmc.Sobol(2 * count, scramble=False).random_base2(max(poses - 1, 1).bit_length())
    angles, planes = max_bend * np.sqrt(points[:, :count]), 2 * np.pi * points[:, count:]  # evenly over discs
    turned = 2 * np.pi * np.arange(EXTREMES)[:, None] / EXTREMES * np.arange(count)
    angles = np.concatenate([angles, np.full((EXTREMES, count), max_bend)])
    return arc.from_polar(angles, np.concatenate([planes, turned])).reshape(-1, 2 * count)


def under_loads(arm: Arm) -> dict[str, Arm]:
    """Return an arm without load (`free`), under gravity alone (`gravity`) and with a payload too (`payload`).

    Gravity and payload are its own, or else it hangs, with 100 g.
    """
    pulled = replace(arm, gravity=arm.gravity if any(arm.gravity) else HANGING, payload=0.0)
    return {"free": arm.unloaded, "gravity": pulled, "payload": replace(pulled, payload=arm.payload or PAYLOAD)}


def weight_over_stiffness(arm: Arm) -> float:
    """Return (m + payload) g L^2/EI [-]; of several sections, L/EI is the sum of theirs."""
    weight = (arm.mass + arm.payload) * math.hypot(*arm.gravity)
    return sum(weight * (arm.length * section.length) / section.bending_stiffness for section in arm.sections)


def scenarios(arm: Arm) -> list[Scenario]:
    """Return the scenarios of an arm; its own gravity, if it has one, takes the place of hanging."""
    own = any(arm.gravity)
    free, pulled, loaded = under_loads(arm).values()
    kg = f"{loaded.payload:g} kg"
    given = [
        Scenario("ideal", "no gravity", free, "servo", ideal_checks),
        Scenario("naive", "no gravity, paper's lengths, plain servos", free, "paper", None),
        Scenario("gravity", "the arm's gravity" if own else "hanging", pulled, "servo", loaded_checks),
        Scenario("payload", f"{'the same' if own else 'hanging'} with {kg}", loaded, "servo", loaded_checks),
    ]
    if not own:
        upright = replace(pulled, gravity=UPRIGHT)
        given.append(Scenario("upright", "standing under its own weight", upright, "servo", loaded_checks))
    return given

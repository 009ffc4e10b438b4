"""The force of one pneumatic muscle against contraction and pressure: McKibben law, static, without friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.pneumatics import force
from contarm_sim.model.arm import Arm
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.parameters import as_numbers, check_count

PRESSURES = (100e3, 200e3, 300e3, 400e3, 500e3, 600e3, 700e3)


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class MuscleCurves:
    """The forces of one muscle of an arm.

    Attributes:
        pressure_pa: gauge pressures [Pa], shape (P,).
        contraction: of rest length [-], negative where it is stretched, shape (C,).
        force_n: [N], shape (P, C).
        braid_angle_rad: at rest [rad].
        rest_length_m: [m].
        blocked_force_n: at rest length under the highest pressure [N].
        max_stretch: up to where the braid closes, share of rest length [-].
    """

    pressure_pa: Array
    contraction: Array
    force_n: Array
    braid_angle_rad: float
    rest_length_m: float
    blocked_force_n: float
    max_stretch: float


def muscle_law(arm: Arm, pressures: Sequence[float] | Array = (), points: int = 9) -> MuscleCurves:
    """Return the force of one muscle from its largest stretch to its largest contraction.

    Args:
        pressures: gauge [Pa]; default 100 to 700 kPa, as far as the muscle takes them.
        points: number of contractions, at least 2.

    Raises:
        InputError: too few points, or a pressure below 0 or above the highest that the muscle takes.
    """
    expect("arm", arm, Arm)
    check_count("points", points, 2)
    most, asked = arm.pneumatics.max_pressure, as_numbers(pressures)
    if asked is None:
        raise InputError("pressures", pressures, f"a sequence of numbers from 0 to {most:g} Pa")
    for pressure in asked:
        if not 0 <= pressure <= most:
            raise InputError("pressure", pressure, f"0 to {most:g} Pa")
    given = np.array(asked or [p for p in PRESSURES if p <= most] or [most], dtype=float)
    contraction = np.linspace(-arm.muscle.max_stretch, arm.pneumatics.max_contraction, points)
    return MuscleCurves(
        pressure_pa=given,
        contraction=contraction,
        force_n=force(given[:, None], arm.muscle_rest_length * (1 - contraction), arm),
        braid_angle_rad=(arm.muscle.braid_angle if isinstance(arm.muscle, McKibben) else math.nan),
        rest_length_m=arm.muscle_rest_length,
        blocked_force_n=arm.muscle.blocked_force,
        max_stretch=arm.muscle.max_stretch,
    )

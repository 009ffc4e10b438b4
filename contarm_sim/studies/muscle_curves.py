"""The force of one pneumatic muscle against contraction and pressure: McKibben law, static, without friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.parameters import as_numbers, check_count

PRESSURES = (100e3, 200e3, 300e3, 400e3, 500e3, 600e3, 700e3)


@dataclass(frozen=True, eq=False, repr=False)  # arrays have no single answer to ==
class MuscleCurves(Shown):
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


def group_of(arm: Arm, section: int | None = None) -> MuscleGroup:
    """Return the muscles of a section.

    Args:
        section: its number, from 1; only one section has muscles, or all are alike, where it is left out.

    Raises:
        InputError: no such section, none with muscles, or sections that differ.
    """
    groups = {group.section + 1: group for group in arm.groups}
    alike = {(group.law, group.length) for group in arm.groups}
    if section is None and len(alike) == 1:
        section = arm.groups[0].section + 1
    if section not in groups:
        given = "not given, and they differ" if section is None else section
        raise InputError("section", given, f"one with muscles: {', '.join(map(str, groups)) or 'there is none'}")
    return groups[section]


def muscle_law(
    arm: Arm, pressures: Sequence[float] | Array = (), points: int = 9, section: int | None = None
) -> MuscleCurves:
    """Return the force of one muscle from its largest stretch to its largest contraction.

    Args:
        section: of several sections, the one that the muscle ends with, from 1; may be left out if all are alike.
        pressures: gauge [Pa]; default 100 to 700 kPa, as far as the muscle takes them.
        points: number of contractions, at least 2.

    Raises:
        InputError: too few points, or a pressure below 0 or above the highest that the muscle takes.
    """
    expect("arm", arm, Arm)
    check_count("points", points, 2)
    group = group_of(arm, section)
    law = group.pneumatics
    most, asked = law.max_pressure, as_numbers(pressures)
    if asked is None:
        raise InputError("pressures", pressures, f"a sequence of numbers from 0 to {most:g} Pa")
    for pressure in asked:
        if not 0 <= pressure <= most:
            raise InputError("pressure", pressure, f"0 to {most:g} Pa")
    given = np.array(asked or [p for p in PRESSURES if p <= most] or [most], dtype=float)
    contraction = np.linspace(-law.max_stretch, law.max_contraction, points)
    return MuscleCurves(
        pressure_pa=given,
        contraction=contraction,
        force_n=law.force(given[:, None], group.rest_length * (1 - contraction), group.rest_length),
        braid_angle_rad=law.braid_angle if isinstance(law, McKibben) else math.nan,
        rest_length_m=group.rest_length,
        blocked_force_n=law.blocked_force,
        max_stretch=law.max_stretch,
    )

"""The answer to the question that people come with: when may I trust constant curvature, for my arm?"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number, check_count
from contarm_sim.results.document import INLINE
from contarm_sim.studies.progress import Track, quietly
from contarm_sim.studies.relinked import can_double, relinked
from contarm_sim.studies.trusted_bends import (
    SMALL,
    STEP,
    WITHIN,
    Trusted,
    first_beyond,
    loaded_arms,
    rounded,
    tip_error,
    tip_errors,
    trusted,
)
from contarm_sim.studies.validation import LARGEST_OF_SECTIONS
from contarm_sim.studies.what_it_takes import WhatItTakes, what_it_takes

WANTED = math.radians(120)
"""Bend that the arm is to be trusted to, unless another is asked for [rad]: that of the spiral."""


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class TrustUnderLoad:
    """One load.

    Attributes:
        trusted: tip error by bend, and the largest bends.
        twice_the_links_deg: the least bends again, one for each bound, with twice the links [deg]; None where so many
            are not possible.
        takes: what it would take to hold to the wanted bend; None where it does.
    """

    trusted: Trusted = field(metadata=INLINE)
    twice_the_links_deg: tuple[float, ...] | None
    takes: WhatItTakes | None


@dataclass(frozen=True, eq=False, repr=False)
class Trust(Shown):
    """How far an arm may bend before constant curvature is off.

    Attributes:
        arm: that was asked about.
        wanted_bend_deg, within_percent: the bend [deg] and the tip error [% of length] that `takes` is about.
        max_bend_deg: the largest bend that was tried [deg]; of several sections that of each of them.
        bend_deg, plane_deg: bend angles and planes that were tried [deg], shapes (A,) and (P,).
        loads: the answers, by load.
    """

    arm: Arm
    wanted_bend_deg: float
    within_percent: float
    max_bend_deg: float
    bend_deg: Array
    plane_deg: Array
    loads: tuple[TrustUnderLoad, ...]


def trust(
    arm: Arm, wanted: float | None = None, within: float = 1.0, planes: int = 12, track: Track = quietly
) -> Trust:
    """Find how far an arm at rest may bend until its tip leaves that of the arcs, by load and by bending plane.

    Every section bends alike, in one plane. Lengths are those that servos reach, so what is found is shape alone:
    weight, and the links.

    Args:
        arm: its own gravity and payload, if it has them, take the place of hanging with 100 g.
        wanted: bend that the arm is to be trusted to [rad]; default 120 deg, 60 deg for each of several sections.
        within: tip error up to which it is trusted there [% of length].
        planes: number of bending planes, evenly spaced.
        track: shows progress.

    Raises:
        InputError: a bend that is not between 0 and 170 deg, a bound that is not positive, too few planes, or friction
            with memory, which single poses leave out.
    """
    expect("arm", arm, Arm)
    arm.refuse_memory("largest bends are found")
    arm.refuse_objects("largest bends are found")
    check_count("planes", planes, 1)
    several = len(arm.sections) > 1
    most = LARGEST_OF_SECTIONS if several else LARGEST_BEND
    bend = as_number(wanted) if wanted is not None else WANTED / (1 + several)
    if math.isnan(bend):
        raise InputError("wanted", repr(wanted), "an angle [rad]")
    if not 0 < bend <= most:
        given = f"{bend:.6g} rad ({math.degrees(bend):.6g} deg)"
        raise InputError("wanted bend", given, f"more than 0, at most {math.degrees(most):.0f} deg")
    if not 0 < as_number(within) < 100:
        raise InputError("within", within, "more than 0 and less than 100 % of length")
    angles, ways = np.append(SMALL, np.arange(STEP, most + 0.5 * STEP, STEP)), 2 * np.pi * np.arange(planes) / planes
    bounds, arms = tuple(sorted({*WITHIN, within})), loaded_arms(arm)
    steps: Iterable[int] = track(range(len(arms)), "loads")
    loads = []
    for i in steps:
        found = trusted(arms[i], angles, ways, bounds)
        takes = what_it_takes(found, angles, ways, bend, within)
        loads.append(TrustUnderLoad(found, _twice_the_links(found, angles), takes))
    tried, around = rounded(np.degrees(angles)), rounded(np.degrees(ways))
    degrees = (round(math.degrees(bend), 6), within, round(math.degrees(most), 6), tried, around)
    return Trust(arm, *degrees, tuple(loads))


def _twice_the_links(found: Trusted, angles: Array) -> tuple[float, ...] | None:
    """Return the least bend within each bound [deg] of an arm of twice the links, in the same planes."""
    arm = found.under.arm
    if not can_double(arm):
        return None
    finer, least, known = relinked(arm, double=True), [], {}
    for bend in found.bends:
        plane = math.radians(bend.towards_deg)
        if plane not in known:
            known[plane] = tip_errors(finer, angles, plane)
        error = partial(tip_error, finer, plane=plane)
        least.append(round(math.degrees(first_beyond(error, angles, known[plane], bend.within_percent)), 6))
    return tuple(least)

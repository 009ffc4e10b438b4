"""The pressure-limited possibility map: which bends pressures hold, free, under gravity and with a payload."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import check_count
from contarm_sim.results.document import shown_if
from contarm_sim.studies.largest_bends import every_bend, fallen_from, held_off, largest_bends_at_rest, posed
from contarm_sim.studies.poses import one_bend
from contarm_sim.studies.progress import Track, quietly
from contarm_sim.studies.scenarios import under_loads

_INSIDE = 0.999
"""Share of a largest bend that the simulated arm is held in."""


@dataclass(frozen=True)
class LargestBend:
    """The largest bends under one load towards one plane [deg]; 0 where pressures hold not even a small one.

    Attributes:
        load: free, gravity or payload.
        plane_deg: the bending plane.
        inflated_deg: with all muscles inflated.
        vented_deg: where one may be vented, or slack if it has no pressure.
        simulated_off_deg: how far off the simulated arm is, held just below `inflated_deg` at constant pressures; None
            where it rests nowhere near, or no bend can be held.
        section: of several sections the one that bends, from 1; else None.
    """

    load: str
    plane_deg: float
    inflated_deg: float
    vented_deg: float
    simulated_off_deg: float | None
    section: int | None = field(default=None, metadata=shown_if(lambda row: row.section is not None))


@dataclass(frozen=True, eq=False, repr=False)  # arrays have no single answer to ==
class Possibility(Shown):
    """Which bends pressures hold.

    Attributes:
        rows: every load, section and plane.
        every_bend_to_deg: by load, up to where every bend in every plane is held, all muscles inflated [deg]; of
            several sections one for each.
        smaller_bends_not_held_deg: by load, the smaller ones of those tried that are not held all the same [deg]; of
            several sections a list for each.
        arm: whose.
        others: of several sections, the bends that those are in which do not bend in a row [rad], shape (S, 2).
    """

    rows: tuple[LargestBend, ...]
    every_bend_to_deg: dict[str, Any]
    smaller_bends_not_held_deg: dict[str, Any]
    arm: Arm
    others: Array | None = field(default=None, metadata=shown_if(lambda found: found.others is not None))


def possibility(arm: Arm, planes: int = 12, track: Track = quietly, others: Array | None = None) -> Possibility:
    """Map the bends that pressures hold, free, under gravity and with a payload (its own, or else hanging, 100 g).

    Largest bends are in closed form without gravity, by the statics of the simulated arm with it. Of several sections,
    each bends by itself, and all muscles of the arm must hold. Muscles without pressures have tensions up to their
    highest.

    Args:
        planes: number of bending planes, spread evenly from that towards muscle 1 of the section that bends.
        track: shows progress.
        others: the pose of the sections that do not bend [rad], shape (S, 2) or (2 S,); default straight.

    Raises:
        InputError: no planes, or not a whole number of them, or a pose for an arm of one section.
    """
    expect("arm", arm, Arm)
    arm.refuse_objects("bends are mapped")
    check_count("planes", planes, 1)
    count = len(arm.sections)
    if others is not None and count == 1:
        raise InputError("others", "a pose", "none for an arm of one section")
    pose = np.zeros(2 * count) if others is None else one_bend(others, arm)
    rows: list[LargestBend] = []
    least: dict[str, Any] = {}
    fallen: dict[str, Any] = {}
    for load, loaded in under_loads(arm).items():
        found = [_of_section(loaded, load, number, pose, planes, track) for number in range(count)]
        rows += [row for own, _, _ in found for row in own]
        least[load], fallen[load] = ([each[i] for each in found] if count > 1 else found[0][i] for i in (1, 2))
    return Possibility(tuple(rows), least, fallen, arm, pose.reshape(-1, 2) if count > 1 else None)


def _of_section(
    arm: Arm, load: str, number: int, pose: Array, planes: int, track: Track
) -> tuple[list[LargestBend], float, list[float]]:
    """Return the rows of one section, the bend angle up to which all are held, and those that are not [deg]."""
    towards = arm.routings[number].angles[0] + 2 * np.pi * np.arange(planes) / planes
    inflated, vented = (np.degrees(bends) for bends in largest_bends_at_rest(arm, towards, number, pose))
    least = float(np.degrees(every_bend(arm, number, pose)))
    fallen = np.degrees(fallen_from(arm, np.radians(least), number, pose)).tolist()
    several, rows = len(arm.sections) > 1, []
    for i in track(range(planes), f"{load}, section {number + 1}" if several else load):
        off = None
        if inflated[i] > 0:
            off = held_off(arm, posed(arm, np.radians(_INSIDE * inflated[i]), towards[i], number, pose))
        rows.append(
            LargestBend(
                load=load,
                plane_deg=float(np.degrees(towards[i]) % 360),
                inflated_deg=float(inflated[i]),
                vented_deg=float(vented[i]),
                simulated_off_deg=None if off is None else float(np.degrees(off)),
                section=number + 1 if several else None,
            )
        )
    return rows, least, fallen

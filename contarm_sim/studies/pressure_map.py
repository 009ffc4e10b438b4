"""The pressure-limited possibility map: which bends pressures hold, free, under gravity and with a payload."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.errors import expect
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import check_count
from contarm_sim.studies.largest_bends import every_bend, fallen_from, held_off, largest_bends_at_rest
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
        vented_deg: where one may be vented.
        simulated_off_deg: how far off the simulated arm is, held just below `inflated_deg` at constant pressures; None
            where it rests nowhere near, or no bend can be held.
    """

    load: str
    plane_deg: float
    inflated_deg: float
    vented_deg: float
    simulated_off_deg: float | None


@dataclass(frozen=True)
class Possibility:
    """Which bends pressures hold.

    Attributes:
        rows: every load and plane.
        every_bend_to_deg: by load, up to where every bend in every plane is held, all muscles inflated [deg].
        smaller_bends_not_held_deg: by load, the smaller ones of those tried that are not held all the same [deg].
        arm: whose.
    """

    rows: tuple[LargestBend, ...]
    every_bend_to_deg: dict[str, float]
    smaller_bends_not_held_deg: dict[str, list[float]]
    arm: Arm


def possibility(arm: Arm, planes: int = 12, track: Track = quietly) -> Possibility:
    """Map the bends that pressures hold, free, under gravity and with a payload (its own, or else hanging, 100 g).

    Largest bends are in closed form without gravity, by the statics of the simulated arm with it.

    Args:
        planes: number of bending planes, spread evenly from that towards muscle 1.
        track: shows progress.

    Raises:
        InputError: no planes, or not a whole number of them.
    """
    expect("arm", arm, Arm)
    check_count("planes", planes, 1)
    towards = 2 * np.pi * np.arange(planes) / planes
    rows: list[LargestBend] = []
    least: dict[str, float] = {}
    fallen: dict[str, list[float]] = {}
    for load, loaded in under_loads(arm).items():
        inflated, vented = (np.degrees(bends) for bends in largest_bends_at_rest(loaded, towards))
        least[load] = float(np.degrees(every_bend(loaded)))
        fallen[load] = np.degrees(fallen_from(loaded, np.radians(least[load]))).tolist()
        for i in track(range(planes), load):
            off = held_off(loaded, np.radians(_INSIDE * inflated[i]), towards[i]) if inflated[i] > 0 else None
            rows.append(
                LargestBend(
                    load=load,
                    plane_deg=float(np.degrees(towards[i])),
                    inflated_deg=float(inflated[i]),
                    vented_deg=float(vented[i]),
                    simulated_off_deg=None if off is None else float(np.degrees(off)),
                )
            )
    return Possibility(tuple(rows), least, fallen, arm)

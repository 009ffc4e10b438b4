"""The tensions and pressures that hold a bend, and whether the simulated arm stays there under them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import EquilibriumError, InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing, shape
from contarm_sim.mechanics.moments import weight_moment
from contarm_sim.mechanics.pressures import holding_pressures, level_range
from contarm_sim.mechanics.statics import balance
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles
from contarm_sim.model.parameters import as_number
from contarm_sim.results.document import shown_if
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.studies.needs import by_pressure, tension_range
from contarm_sim.studies.poses import by_group, by_section, one_bend

NEAR = math.radians(10)
"""How far from a bend, which is balanced as a whole under load, the simulated arm still counts as held there [rad]."""


@dataclass(frozen=True, eq=False, repr=False)  # arrays have no single answer to ==
class Hold(Shown):
    """What holds a bend, in closed form, and what the simulated arm does under it.

    Of several sections, lists: an entry for each section, or for the muscles that end with it.

    Attributes:
        bend: [rad], shape (2,); of several sections (S, 2).
        muscle_lengths: [m], shape (n,); of several sections a tuple of such arrays.
        actuator_tensions: [N], pulling > 0, likewise.
        pressures: gauge [Pa], likewise; None where muscles of a section have no pressures.
        weight_moment: moment of mass and payload on the bend [N m], shape (2,); of several sections (S, 2).
        cocontraction: tensions that hold the bend by themselves, of mean 1, shape (n,); of several sections one
            direction for each, shape (S, n), over all muscles.
        level: co-contraction beyond the balance [N]; of several sections one for each.
        level_range: what pressures, or else the highest tensions, allow of it [N], likewise.
        simulated_off: how far from the bend the simulated arm rests under the pressures, or the tensions [rad]; of
            several sections that of the worst; None if not near.
    """

    bend: Array
    muscle_lengths: Array | tuple[Array, ...]
    actuator_tensions: Array | tuple[Array, ...]
    pressures: Array | tuple[Array, ...] | None = field(metadata=shown_if(lambda found: found.pressures is not None))
    weight_moment: Array
    cocontraction: Array
    level: float | tuple[float, ...]
    level_range: tuple[float, float] | tuple[tuple[float, float], ...]
    simulated_off: float | None


def hold(arm: Arm, bend: Array, share: float = 0.0) -> Hold:
    """Return what holds a bend [rad], shape (2,); of several sections (S, 2) or (2 S,).

    Under gravity and payload tensions balance the weight's moment on the bends as a whole, not the sag between.

    Args:
        share: co-contraction, from 0, the least that pressures allow, to 1, the most. Muscles without pressures pull
            from their least to their highest tension.

    Raises:
        InputError: pressures, or tensions, cannot hold the bend; says what it would take. Or a share out of range.
    """
    expect("arm", arm, Arm)
    arm.refuse_objects("bends are held")
    if not 0 <= as_number(share) <= 1:
        raise InputError("share", share, "0 to 1")
    bend, several = one_bend(bend, arm), len(arm.sections) > 1
    held = balance(bend, arm)
    pneumatic = by_pressure(arm)
    lows, highs = level_range(held, arm) if pneumatic else tension_range(held, arm)
    pressures = holding_pressures(bend, arm, share) if pneumatic else None
    if pressures is None:
        tensions = held.at(lows + share * (highs - lows))
        drive = Muscles(kind="tensions", values=tuple(tensions))
    else:
        tensions = pressures * held.per_pascal
        drive = Muscles(kind="pressures", values=tuple(pressures))
    ranges = tuple((float(low), float(high)) for low, high in zip(lows, highs, strict=True))
    levels = tuple(low + share * (high - low) for low, high in ranges)
    return Hold(
        bend=by_section(bend, arm),
        muscle_lengths=by_group(routing.lengths_from_bend(bend, arm), arm),
        actuator_tensions=by_group(tensions, arm),
        pressures=None if pressures is None else by_group(pressures, arm),
        weight_moment=by_section(weight_moment(bend, arm), arm),
        cocontraction=held.cocontraction if several else held.cocontraction[0],
        level=levels if several else levels[0],
        level_range=ranges if several else ranges[0],
        simulated_off=_off(arm, bend, drive),
    )


def _off(arm: Arm, bend: Array, drive: Muscles) -> float | None:
    """Return how far from a bend the simulated arm rests with its muscles so driven [rad]; None if not near."""
    try:
        found = equilibrium(arm, Load(muscles=drive))
    except EquilibriumError:
        return None
    off = shape.bends_of(routing.bend_from_lengths(found.muscle_lengths, arm)[0] - bend, arm)
    worst = float(np.hypot(off[:, 0], off[:, 1]).max())
    return worst if found.stable and worst < NEAR else None

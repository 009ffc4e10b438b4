"""The tensions and pressures that hold a bend, and whether the simulated arm stays there under them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from contarm_sim.errors import EquilibriumError, InputError, expect
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.moments import weight_moment
from contarm_sim.mechanics.pressures import holding_pressures, level_range
from contarm_sim.mechanics.statics import balance
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles
from contarm_sim.model.parameters import as_number
from contarm_sim.statics.equilibrium import equilibrium

NEAR = math.radians(10)
"""How far from a bend, which is balanced as a whole under load, the simulated arm still counts as held there [rad]."""


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class Hold:
    """What holds a bend, in closed form, and what the simulated arm does under it.

    Attributes:
        bend: [rad], shape (2,).
        muscle_lengths: [m], shape (n,).
        actuator_tensions: [N], pulling > 0, shape (n,).
        pressures: gauge [Pa], shape (n,).
        weight_moment: moment of mass and payload on the bend [N m], shape (2,).
        cocontraction: tensions that hold the bend by themselves, of mean 1, shape (n,).
        level: co-contraction beyond the balance [N].
        level_range: what pressures allow of it [N].
        simulated_off: how far from the bend the simulated arm rests under the pressures [rad]; None if not near.
    """

    bend: Array
    muscle_lengths: Array
    actuator_tensions: Array
    pressures: Array
    weight_moment: Array
    cocontraction: Array
    level: float
    level_range: tuple[float, float]
    simulated_off: float | None


def hold(arm: Arm, bend: Array, share: float = 0.0) -> Hold:
    """Return what holds a bend [rad], shape (2,).

    Under gravity and payload tensions balance the weight's moment on the bend as a whole, not the sag between.

    Args:
        share: co-contraction, from 0, the least that pressures allow, to 1, the most.

    Raises:
        InputError: pressures cannot hold the bend; says what it would take. Or a share out of range.
    """
    expect("arm", arm, Arm)
    if not 0 <= as_number(share) <= 1:
        raise InputError("share", share, "0 to 1")
    bend = arc.one_bend(bend)
    held = balance(bend, arm)
    pressures = holding_pressures(bend, arm, share)
    low, high = (float(level[0]) for level in level_range(held, arm))
    return Hold(
        bend=bend,
        muscle_lengths=routing.lengths_from_bend(bend, arm),
        actuator_tensions=pressures * held.per_pascal,
        pressures=pressures,
        weight_moment=weight_moment(bend, arm),
        cocontraction=held.cocontraction[0],
        level=low + share * (high - low),
        level_range=(low, high),
        simulated_off=_off(arm, bend, pressures),
    )


def _off(arm: Arm, bend: Array, pressures: Array) -> float | None:
    """Return how far from a bend the simulated arm rests under pressures [Pa] [rad]; None if not near."""
    try:
        found = equilibrium(arm, Load(muscles=Muscles(kind="pressures", values=tuple(pressures))))
    except EquilibriumError:
        return None
    off = float(np.hypot(*(routing.bend_from_lengths(found.muscle_lengths, arm)[0] - bend)))
    return off if found.stable and off < NEAR else None

"""Forward kinematics: arcs of growing bend, and the simulated arm at rest beside them."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.view.colours import SIMULATED
from contarm_sim.view.figures.common import bend_colours
from contarm_sim.view.once import once
from contarm_sim.view.space import add_space
from contarm_sim.view.stance import stance
from contarm_sim.view.style import Sheet
from contarm_sim.view.trim import trim

BENDS = (30, 60, 90, 120, 150)
"""[deg]."""

_OFF = (-15, 105, 225)
"""Planes [deg] off the one that is seen without foreshortening: all are told apart."""

_POINTS = np.linspace(0, 1, 60)


def fan(sheet: Sheet, arm: Arm) -> None:
    """Draw arcs of growing bend in three planes, and in one of these the simulated arm at rest under its own loads."""
    sheet.heading(f"Arcs of constant curvature by bend, and the simulated arm at rest ({stance(arm)})")
    ax = add_space(sheet, arm)
    planes = ax.broadside + np.radians(_OFF)
    shown = float(planes[0])
    for plane in planes[::-1]:
        for degrees, colour in zip(BENDS, bend_colours(BENDS), strict=True):
            line = arc.position(arc.from_polar(np.radians(degrees), plane), arm.length, _POINTS)
            label = "arc, coloured by bend" if (degrees, plane) == (90, shown) else None
            ax.trace(line, color=colour, linewidth=1.6 if plane == shown else 1.0, label=label)
    bends, chains = _at_rest(arm, shown)
    look = {"color": SIMULATED, "linestyle": "", "marker": "o", "markersize": 2.2}
    for degrees, bend, stations in zip(BENDS, bends, chains, strict=True):
        ax.trace(stations, **look, label="simulated at rest" if degrees == BENDS[0] else None)
        before, tip = arc.position(bend, arm.length, np.array([0.99, 1.0]))
        ax.note(tip, f"{degrees}°", away=tip - before)
    ax.settle()
    trim(sheet, 105)


@once
def _at_rest(arm: Arm, plane: float) -> tuple[Array, Array]:
    """Return bends in a plane [rad], shape (K, 2), and stations of the arm at rest there [m], shape (K, N + 1, 3)."""
    bends = arc.from_polar(np.radians(BENDS), plane)
    return bends, poses_at_rest(arm, Reference.from_bends(bends, arm)).stations

"""The pressure-limited possibility map as a figure."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics import arc, muscles
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.pressures import pressure_needed
from contarm_sim.model.arm import Arm
from contarm_sim.model.pneumatic_law import PneumaticLaw
from contarm_sim.view.colours import BLACK, RED
from contarm_sim.view.style import Sheet


def no_map(arm: Arm) -> str | None:
    """Say what an arm would have to be for its map to be drawn, or None: it is of the paper's muscles."""
    if len(arm.sections) > 1:
        return "an arm of one section"
    if not isinstance(arm.laws[0], PneumaticLaw):
        return "muscles with pressures"
    angles = arm.routing.angles
    return None if len(angles) == 3 and muscles.evenly_spaced(angles) else "three evenly spaced muscles"


def draw_possibility(fig: Sheet, arms: dict[str, Arm]) -> None:
    """Draw, over the lengths of muscles 2 and 3, the pressure that holds each bend, one panel an arm.

    The outer ellipse is the paper's, bends of 180 deg.
    """
    angles, planes = np.radians(np.linspace(0, 179.9, 120)), np.linspace(0, 2 * np.pi, 541)
    bend = arc.from_polar(angles[:, None], planes)
    fig.tall(94)
    axes = fig.subplots(1, len(arms), sharey=True, squeeze=False)[0]
    filled: Any = None
    for ax, (name, arm) in zip(axes, arms.items(), strict=True):
        deltas = 1e3 * routing.arc_deltas(bend, arm)
        need = np.minimum(pressure_needed(bend, arm)[1], 1e9) / 1e3
        highest = arm.pneumatics.max_pressure / 1e3
        levels = np.linspace(0, highest, 8)
        filled = ax.contourf(deltas[..., 1], deltas[..., 2], np.minimum(need, 2 * highest), levels, cmap="cividis")
        ax.contour(deltas[..., 1], deltas[..., 2], np.minimum(need, 2 * highest), [highest], colors=RED)
        ax.plot(deltas[-1, :, 1], deltas[-1, :, 2], color=BLACK, linewidth=1.0)
        ax.plot([], [], color=BLACK, linewidth=1.0, label="paper's ellipse, 180°")
        ax.plot([], [], color=RED, label=f"{highest:.0f} kPa")
        ax.set_aspect("equal")
        edge = 1.04 * np.abs(deltas).max()
        ax.set(xlim=(-edge, edge), ylim=(-edge, edge))
        pull, payload = " ".join(f"{x:g}" for x in arm.gravity), f", {arm.payload:g} kg" if arm.payload else ""
        ax.set_title(f"gravity {pull} m/s²{payload}" if any(arm.gravity) else name)
        ax.set_xlabel("length change of muscle 2 [mm]")
    axes[0].set_ylabel("length change of muscle 3 [mm]")
    fig.colorbar(filled, ax=axes, label="highest pressure needed [kPa]", shrink=0.8)
    fig.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)

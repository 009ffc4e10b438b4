"""The pressure-limited possibility map as a figure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.kinematics import arc, muscles
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.pressures import ways_to_hold
from contarm_sim.mechanics.statics import balance
from contarm_sim.model.arm import Arm
from contarm_sim.model.pneumatic_law import PneumaticLaw
from contarm_sim.view.colours import ANALYTIC, BLACK
from contarm_sim.view.once import once
from contarm_sim.view.stance import stance
from contarm_sim.view.style import Sheet

_BENDS, _PLANES = np.radians(np.linspace(0, 179.9, 120)), np.linspace(0, 2 * np.pi, 361)
_COLOURS = "cividis_r"
ELLIPSE = "paper's ellipse, bends of 180°"


@dataclass(frozen=True, eq=False)
class Map:
    """What bends ask of the muscles, over a grid of bend angles and planes.

    Attributes:
        deltas: length changes of muscles [mm], shape (bends, planes, 3).
        ways: the ways to hold a bend: highest pressure, and margin above zero where the way is there, both [Pa] and of
            shape (bends, planes).
    """

    deltas: Array
    ways: tuple[tuple[Array, Array], ...]

    def room(self, pressure: float) -> Array:
        """Return what is left of a pressure [Pa] in the best way to hold a bend, shape (bends, planes).

        Bends that it holds have zero or more. It has no jumps, unlike the least pressure itself where a way ends: its
        contours are sharp.
        """
        with np.errstate(invalid="ignore"):
            left = [np.minimum(pressure - need, margin) for need, margin in self.ways]
        return np.max(np.nan_to_num(np.clip(left, -pressure, pressure), nan=-pressure), axis=0)

    def fill(self, ax: Any, pressure: float, colour: Any) -> None:
        """Fill what a pressure [Pa] holds with a colour."""
        ax.contourf(*self._places, self.room(pressure), [0.0, np.inf], colors=[colour])

    def edge(self, ax: Any, pressure: float, **look: Any) -> None:
        """Draw the edge of what a pressure [Pa] holds."""
        ax.contour(*self._places, self.room(pressure), [0.0], **look)

    def frame(self, ax: Any) -> None:
        """Draw the paper's ellipse, and set equal scales and limits."""
        ax.plot(self.deltas[-1, :, 1], self.deltas[-1, :, 2], color=ANALYTIC, linewidth=1.2, label=ELLIPSE)
        side = 1.06 * np.abs(self.deltas).max()
        ax.set(xlim=(-side, side), ylim=(-side, side))
        ax.set_aspect("equal", anchor="N")

    @property
    def _places(self) -> tuple[Array, Array]:
        return self.deltas[..., 1], self.deltas[..., 2]


@once
def map_of(arm: Arm) -> Map:
    """Return the map of an arm."""
    bend = arc.from_polar(_BENDS[:, None], _PLANES)
    inflated, (vented,) = ways_to_hold(balance(bend, arm), arm)
    always = np.full(inflated.shape[:-1], np.inf)
    return Map(1e3 * routing.arc_deltas(bend, arm), ((inflated[..., 0], always), *vented))


def no_map(arm: Arm) -> str | None:
    """Say what an arm would have to be for its map to be drawn, or None: it is of the paper's muscles."""
    if len(arm.sections) > 1:
        return "an arm of one section"
    if not isinstance(arm.laws[0], PneumaticLaw):
        return "muscles with pressures"
    angles = arm.routing.angles
    return None if len(angles) == 3 and muscles.evenly_spaced(angles) else "three evenly spaced muscles"


def draw_possibility(sheet: Sheet, arms: dict[str, Arm]) -> None:
    """Draw, over the lengths of muscles 2 and 3, the pressure that holds each bend, one panel an arm.

    The outer ellipse is the paper's, bends of 180 deg.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.lines import Line2D

    sheet.heading("Muscle lengths that pressures can hold")
    highest = max(arm.pneumatics.max_pressure for arm in arms.values())
    levels = highest * np.linspace(0, 1, 8)
    colours = colormaps[_COLOURS](np.linspace(0.06, 0.94, len(levels) - 1))
    sheet.tall((70.0 if sheet.wide else 108.0) + 5.0 * sheet.titled)
    shape = (1, len(arms)) if sheet.wide else (-(-len(arms) // 2), 2)
    grid = sheet.subplots(*shape, sharex=True, sharey=True, squeeze=False)
    panels = list(grid.flat)
    for ax, arm in zip(panels, arms.values(), strict=False):
        found = map_of(arm)
        for level, colour in zip(levels[:0:-1], colours[::-1], strict=True):  # each over the one before
            found.fill(ax, level, colour)
        found.edge(ax, arm.pneumatics.max_pressure, colors=BLACK, linewidths=1.0)
        found.frame(ax)
        ax.set_title(stance(arm))
    grid[-1, (len(arms) - 1) // 2 if sheet.wide else 0].set_xlabel("length change\nof muscle 2 [mm]")
    grid[-1, 0].set_ylabel("length change\nof muscle 3 [mm]")
    scale = ScalarMappable(BoundaryNorm(levels / 1e3, len(colours)), ListedColormap(colours))
    spare = panels[len(arms) :]
    for ax in spare:
        ax.set_axis_off()
    within = {"cax": spare[0].inset_axes((0.05, 0.0, 0.1, 1.0))} if spare else {"ax": panels, "aspect": 28, "pad": 0.02}
    sheet.colorbar(scale, label="highest pressure\nneeded [kPa]", **within)
    limit = Line2D([], [], color=BLACK, linewidth=1.0, label=f"held by up to {highest / 1e3:.0f} kPa")
    handles = [limit, panels[0].get_legend_handles_labels()[0][0]]
    sheet.legend(handles=handles, loc="outside lower center", ncols=2 if sheet.wide else 1)

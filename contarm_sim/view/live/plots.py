"""What happened in the last seconds, as curves beside the scene."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import slices
from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import muscle_hex
from contarm_sim.view.live.session import Reading
from contarm_sim.view.sections import pressure_limits, section_hex

_SHOWN, _EVERY = 10.0, 0.05
"""Time that the plots show, and between their points [s]."""

_WORDS = ("red", "blue", "amber", "teal", "brown", "pink")
"""Colours of the muscles of a section, in their order."""


class Plots:
    """Tip error, tensions and pressures of the last seconds; of several sections a plot of tensions for each.

    Pressures of several sections are the highest of each section's muscles.
    """

    def __init__(self, gui: Any, arm: Arm) -> None:
        self._groups, self._length = slices(arm), arm.length
        self._several = len(arm.sections) > 1
        self._points: deque[tuple[float, ...]] = deque(maxlen=round(_SHOWN / _EVERY))
        self._rows: list[slice] = []
        self._plots: list[Any] = []
        self._add(gui, "tip error [mm]", {"error": "#7526cc"}, 1.0)
        for group, own in zip(arm.groups, self._groups, strict=True):
            count = own.stop - own.start
            muscles = {f"{i + 1}": muscle_hex(i) for i in range(count)}
            said = ", ".join(f"{i + 1} {_WORDS[i % len(_WORDS)]}" for i in range(count))
            title = f"section {group.section + 1}: tension [N]" if self._several else f"tension [N]: {said}"
            self._add(gui, title, muscles, 10.0)
        if not np.isfinite(pressure_limits(arm)).all():  # some muscles that no pressure drives
            return
        if self._several:
            names = {f"{group.section + 1}": section_hex(group.section) for group in arm.groups}
            self._add(gui, "pressure needed, by section [kPa]", names, 100.0)
        else:
            self._add(gui, "pressure needed [kPa]", {str(i + 1): muscle_hex(i) for i in range(len(muscles))}, 100.0)

    def _add(self, gui: Any, title: str, lines: dict[str, str], least: float) -> None:
        from viser import uplot

        series = [uplot.Series(label="t [s]")]
        series += [uplot.Series(label=name, stroke=colour, width=2) for name, colour in lines.items()]
        first = self._rows[-1].stop if self._rows else 1
        self._rows.append(slice(first, first + len(lines)))
        self._plots.append(
            gui.add_uplot(
                (np.zeros(1),) * len(series), tuple(series), title=title, height=140, padding=(10, 24, 0, 0),
                scales={"x": uplot.Scale(time=False, auto=True), "y": {"range": _from_zero(least)}},
                legend=uplot.Legend(show=False),
            )
        )  # fmt: skip

    def clear(self) -> None:
        """Forget all points."""
        self._points.clear()

    def note(self, reading: Reading) -> None:
        """Take a point, if it is time for one."""
        if self._points and 0 <= reading.time - self._points[-1][0] < _EVERY:
            return
        pressures = np.where(np.isfinite(reading.pressures), 1e-3 * reading.pressures, np.nan)
        if self._several:
            pressures = np.array([pressures[own].max() for own in self._groups])
        self._points.append((reading.time, 1e3 * reading.error, *reading.tensions, *pressures))

    def show(self) -> None:
        """Draw the points."""
        if self._points:
            points: Array = np.array(self._points).T
            for plot, rows in zip(self._plots, self._rows, strict=True):
                plot.data = (points[0], *points[rows])


def _from_zero(least: float) -> Any:
    """Return the range of an axis that shows 0, and `least`, and more if there is more."""
    return {"min": {"pad": 0.1, "soft": 0.0, "mode": 1}, "max": {"pad": 0.1, "soft": least, "mode": 1}}

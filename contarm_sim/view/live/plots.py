"""What happened in the last seconds, as curves beside the scene."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import slices
from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import muscle_hex
from contarm_sim.view.colours import CONTACT, ERROR
from contarm_sim.view.live.session import Reading
from contarm_sim.view.sections import pressure_limits, section_hex

_LOWER = 0.8
"""Height of plots where there is one more, over their usual one: all are seen at once."""

_SHOWN, _EVERY = 10.0, 0.05
"""Time that the plots show, and between their points [s]."""


class Plots:
    """Tip error, tensions and pressures of the last seconds; of several sections a plot of tensions for each.

    Pressures of several sections are the highest of each section's muscles.
    """

    def __init__(self, gui: Any, arm: Arm) -> None:
        self._groups, self._length = slices(arm), arm.length
        self._several = len(arm.sections) > 1
        self._count = 0
        self._points: deque[tuple[float, ...]] = deque(maxlen=round(_SHOWN / _EVERY))
        self._rows: list[slice] = []
        self._plots: list[Any] = []
        self._touchable = arm.world.touchable
        self._share = _LOWER if self._touchable else 1.0
        self._add(gui, "tip error [mm]", {"tip error": ERROR}, 1.0, 135)
        if self._touchable:
            self._add(gui, "contact force [N]", {"contact force": CONTACT}, 1.0, 135)
        for group, own in zip(arm.groups, self._groups, strict=True):
            muscles = {f"muscle {i + 1}": muscle_hex(i) for i in range(own.stop - own.start)}
            self._add(
                gui, f"tension of section {group.section + 1} [N]" if self._several else "tension [N]", muscles, 10.0
            )
        if not np.isfinite(pressure_limits(arm)).all():  # some muscles that no pressure drives
            return
        if self._several:
            muscles = {f"section {group.section + 1}": section_hex(group.section) for group in arm.groups}
        self._add(gui, "highest pressure needed [kPa]" if self._several else "pressure needed [kPa]", muscles, 100.0)

    def _add(self, gui: Any, title: str, lines: dict[str, str], least: float, height: int = 150) -> None:
        from viser import uplot

        series = [uplot.Series(label="t [s]")]
        series += [uplot.Series(label=name, stroke=colour, width=2) for name, colour in lines.items()]
        first = self._rows[-1].stop if self._rows else 1
        self._rows.append(slice(first, first + len(lines)))
        self._plots.append(
            gui.add_uplot(
                (np.zeros(1),) * len(series), tuple(series), title=title, height=round(self._share * height),
                padding=(10, 24, 0, 0),
                scales={"x": uplot.Scale(time=False, auto=True), "y": {"range": _from_zero(least)}},
                axes=(uplot.Axis(label="t [s]", labelSize=16, size=34), uplot.Axis(size=44)),
                legend=uplot.Legend(show=len(lines) > 1, live=False),
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
        self._count += 1
        touch = (reading.contact,) if self._touchable else ()
        self._points.append((reading.time, 1e3 * reading.error, *touch, *reading.tensions, *pressures))

    def show(self, thinning: int = 1) -> None:
        """Draw one of so many points, the one with the largest error, and the newest.

        Points are picked by when they came, so that a curve does not change as it moves on.
        """
        if self._points:
            points: Array = np.array(self._points)
            numbers = self._count - len(points) + np.arange(len(points))
            groups = np.split(np.arange(len(points)), np.flatnonzero(np.diff(numbers // thinning)) + 1)
            picked = [group[points[group, 1].argmax()] for group in groups]
            points = points[np.unique([*picked, len(points) - 1])].T
            for plot, rows in zip(self._plots, self._rows, strict=True):
                plot.data = (points[0], *points[rows])


def _from_zero(least: float) -> Any:
    """Return the range of an axis that shows 0, and `least`, and more if there is more."""
    return {"min": {"pad": 0.1, "soft": 0.0, "mode": 1}, "max": {"pad": 0.1, "soft": least, "mode": 1}}

"""The figure of free swings: displacement over time, frequency and damping of each release."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.identify.replays.replay import Replay
from contarm_sim.view.colours import LIMIT, MEASURED, SIMULATED
from contarm_sim.view.report.replays.words import named
from contarm_sim.view.style import Sheet

MM = 1e3

CURVES = 6
"""Releases whose swings are drawn, evenly picked; all have a dot."""


_NAMED, _SHORT = 6, 8
"""Most blocks that are named along an axis, and the most letters of such a name."""


def draw_swings(sheet: Sheet, replay: Replay) -> None:
    """Draw some swings along the lines that they lie on, and frequency and damping of all, measured and simulated."""
    swings = replay.swings
    across = min(3 if sheet.wide else 2, len(swings))
    count = min(CURVES, len(swings) // across * across)  # no row is left open
    some = np.linspace(0, len(swings) - 1, count).round().astype(int).tolist()
    down = count // across
    sheet.tall((38 if sheet.wide else 34) * down + 64)
    parts: Any = sheet.subfigures(2, 1, height_ratios=[(38 if sheet.wide else 34) * down + 4, 56])
    top, foot = parts
    curves = top.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    for ax, k in zip(curves.ravel(), some, strict=True):
        one = swings[k]
        time = replay.recording.time[one.rows] - replay.recording.time[one.rows[0]]
        along = [at[one.rows, -1] @ one.measured.direction for at in (replay.recording.positions, replay.predicted)]
        rest = np.nanmedian(along[0])
        ax.plot(time, MM * (along[0] - rest), color=MEASURED, linewidth=1.0, label="measured")
        ax.plot(time, MM * (along[1] - rest), color=SIMULATED, linewidth=1.0, label="simulated")
        ax.set_title(named(one.block)[:30])
    for ax in curves[:, 0]:
        ax.set_ylabel("along the\nswing [mm]")
    for ax in curves[-1]:
        ax.set_xlabel("time [s]")
    panels = foot.subplots(1, 2)
    numbers = np.arange(1, len(swings) + 1)
    quantities: tuple[tuple[Any, str, str], ...] = (
        (panels[0], "frequency", "frequency, simulated\nless measured [%]"),
        (panels[1], "damping", "damping, simulated\nless measured [%]"),
    )  # fmt: skip
    for ax, name, words in quantities:
        each = np.array([getattr(one, f"{name}_percent") for one in swings])
        ax.axhline(0, color=MEASURED, linewidth=1.0)
        ax.vlines(numbers, 0, each, color=LIMIT, linewidth=0.8)
        ax.plot(numbers, each, "D", color=SIMULATED)
        off = float(np.median(each))
        median = " (median)" if sheet.wide and len(swings) > 1 else ""
        ax.set_title(f"{name}: {off:+.1f} %{median}".replace("-", "\N{MINUS SIGN}"))
        ax.set(xlabel="block", ylabel=words, xlim=(0.3, len(swings) + 0.7))
        most = 1.2 * float(np.abs(each).max()) or 1.0
        ax.set_ylim(-most, most)
        if len(swings) <= _NAMED and max(len(one.block) for one in swings) <= _SHORT:
            ax.set_xticks(numbers, [one.block for one in swings])
        else:
            ax.xaxis.get_major_locator().set_params(integer=True)
    sheet.legend(*curves[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    sheet.heading("Free swings of the last marker, from where the hand has let go")

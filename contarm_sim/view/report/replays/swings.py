"""The figure of free swings: displacement over time, frequency and damping of each release."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.identify.replay import Replay
from contarm_sim.view.colours import LIMIT, MEASURED, SIMULATED
from contarm_sim.view.report.replays.words import named
from contarm_sim.view.style import Sheet

MM = 1e3

CURVES = 6
"""Releases whose swings are drawn, evenly picked; all have a dot."""


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
        ax.set_ylabel("along [mm]")
    for ax in curves[-1]:
        ax.set_xlabel("time [s]")
    panels = foot.subplots(1, 2)
    numbers = np.arange(1, len(swings) + 1)
    quantities: tuple[tuple[Any, str, str], ...] = (
        (panels[0], "frequency", "frequency [Hz]"), (panels[1], "damping", "damping [1/s]"),
    )  # fmt: skip
    for ax, name, words in quantities:
        real = np.array([getattr(one.measured, name) for one in swings])
        own = np.array([getattr(one.simulated, name) for one in swings])
        ax.vlines(numbers, real, own, color=LIMIT, linewidth=0.8)
        ax.plot(numbers, real, "o", color=MEASURED, label="measured")
        ax.plot(numbers, own, "D", color=SIMULATED, label="simulated")
        off = 100 * (np.median(own / real) - 1)
        median = " (median)" if sheet.wide and len(swings) > 1 else ""
        ax.set_title(f"{name}: {off:+.1f} %{median}".replace("-", "\N{MINUS SIGN}"))
        ax.set(xlabel="release", ylabel=words, xlim=(0.3, len(swings) + 0.7))
        ax.set_ylim(0, 1.12 * float(max(real.max(), own.max())))
        ax.xaxis.get_major_locator().set_params(integer=True)
    sheet.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    sheet.heading("Free swings of the last marker, from where the hand has let go")

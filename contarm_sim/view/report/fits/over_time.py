"""Errors of the last marker over time, and where it was measured and predicted."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from contarm_sim.identify.fitted import Left
from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.colours import BLUE, FAINT, NOTE, ORANGE
from contarm_sim.view.report.fits.left_over import FITTED, HELD_OUT, distances, parts
from contarm_sim.view.report.outliers import enlarged, outliers, reach, told
from contarm_sim.view.style import Sheet

COLOURS = {FITTED: BLUE, HELD_OUT: ORANGE}
MARKS = {FITTED: "o", HELD_OUT: "^"}
"""Dots of what was fitted and held out."""

_BLOCKS = 40
"""Blocks are shaded in turn where there are no more."""


def draw_over_time(sheet: Sheet, left: Left) -> None:
    """Draw how large the errors of the last marker are, and their components, over time."""
    recording = left.recording
    axis, label = _axis(left)
    sheet.tall(118)
    rows: Any = sheet.subplots(4, 1, sharex=True, height_ratios=[1.5, 1, 1, 1])
    sizes = 1e3 * distances(left)[:, -1]
    sides = [1e3 * left.error[:, -1, k] for k in range(3)]
    highest, beyond = reach(sizes)
    kept = np.abs(np.where(outliers(sizes), np.nan, sides))
    most = 1.08 * float(np.nanmax(kept, initial=0.0)) or 1.0
    name = recording.rig.markers[-1].name
    words = [f"error of {name}\n[mm]", *(f"{axis_name} [mm]" for axis_name in "xyz")]
    for ax, values, word in zip(rows, [sizes, *sides], words, strict=True):
        _shade(ax, left, axis)
        for part, own in parts(left).items():
            if recording.kind == "motion":
                ax.plot(axis, np.where(own, values, np.nan), color=COLOURS[part], linewidth=0.9, label=part)
            else:
                ax.plot(axis[own], values[own], MARKS[part], color=COLOURS[part], markersize=1.8, label=part,
                        rasterized=True)  # fmt: skip
        ax.set_ylabel(word)
        if ax is rows[0]:
            ax.set_ylim(0, highest)
        else:
            ax.set_ylim(-most, most)
            ax.axhline(0, color="black", linewidth=0.6)
    rows[-1].set_xlabel(label)
    rows[-1].margins(x=0.01)
    sheet.align_ylabels()
    handles, labels = rows[0].get_legend_handles_labels()
    sheet.legend(handles, labels, loc="outside lower center", ncols=2, markerscale=2)
    left_out = f"; {told(beyond)} beyond" if beyond else ""
    sheet.heading(f"Errors of {name}: measured less predicted{left_out}")


def _axis(left: Left) -> tuple[Array, str]:
    """Return what is drawn along: time, where it grows, or else the number of the sample."""
    recording = left.recording
    if recording.kind == "motion" and (np.diff(recording.time) > 0).all():
        return recording.time, "time [s]"
    return np.arange(1.0, len(recording) + 1), "sample, in the order of the recording"


def _shade(ax: Any, left: Left, axis: Array) -> None:
    """Shade every other block."""
    named = left.recording.blocks
    starts = [0, *(np.flatnonzero(named[1:] != named[:-1]) + 1).tolist(), len(named)]
    if len(starts) - 1 > _BLOCKS:
        return
    for first, end in list(itertools.pairwise(starts))[1::2]:
        half = 0.5 * float(axis[1] - axis[0])
        ax.axvspan(axis[first] - half, axis[end - 1] + half, color=FAINT, alpha=0.35, linewidth=0, zorder=0)


def draw_paths(sheet: Sheet, left: Left) -> None:
    """Draw where the last marker was measured and predicted, from three sides."""
    recording = left.recording
    measured, predicted = 1e3 * recording.positions[:, -1], 1e3 * left.predicted[:, -1]
    moving = recording.kind == "motion"
    far = outliers(distances(left)[:, -1])
    extent = np.maximum(np.nanmax(np.concatenate([measured, predicted]), axis=0)
                        - np.nanmin(np.concatenate([measured, predicted]), axis=0), 1.0)  # fmt: skip
    flat = extent[2] / max(extent[0], extent[1])
    sizes = 1e3 * distances(left)[:, -1][~far]
    often = enlarged(float(np.nanmax(sizes, initial=0.0) / extent.max()))
    for ax, (across, up) in _sides(sheet, float(flat)):
        for part, own in parts(left).items():
            colour = COLOURS[part]
            if moving:
                ax.plot(*np.where(own[:, None], measured, np.nan)[:, (across, up)].T, color=colour, linewidth=2.2,
                        alpha=0.55, label=f"measured, {part}")  # fmt: skip
                continue
            known = own & ~far & np.isfinite(measured).all(axis=1) & np.isfinite(predicted).all(axis=1)
            tips = measured[known] + often * (predicted - measured)[known]
            ends = np.stack([tips, measured[known], np.full((known.sum(), 3), np.nan)], axis=1)
            ax.plot(*ends.reshape(-1, 3)[:, (across, up)].T, color=colour, linewidth=0.8, alpha=0.8)
            ax.plot(*measured[known][:, (across, up)].T, MARKS[part], color=colour, markersize=1.7,
                    label=f"measured, {part}")  # fmt: skip
        if moving:
            ax.plot(*predicted[:, (across, up)].T, color="black", linewidth=0.7, label="predicted")
        ax.set_aspect("equal", adjustable="box")
        ax.set_xlabel(f"{'xyz'[across]} [mm]")
        ax.set_ylabel(f"{'xyz'[up]} [mm]")
        ax.locator_params(axis="x", nbins=5)
        ax.locator_params(axis="y", nbins=3 if up == 2 and flat < 0.4 else 5)
    handles, labels = ax.get_legend_handles_labels()
    if not moving:
        handles.append(ax.plot([], [], color=NOTE, linewidth=0.9)[0])
        labels.append("towards the predicted place" + (f", {often} times as long" if often > 1 else ""))
    sheet.legend(handles, labels, loc="outside lower center", ncols=3 if sheet.wide else 1, markerscale=2)
    of = f"; without {told(int(far.sum()))}" if far.any() and not moving and sheet.wide else ""
    sheet.heading(f"Measured and predicted places of {recording.rig.markers[-1].name}, from three sides{of}")


def _sides(sheet: Sheet, flat: float) -> list[tuple[Any, tuple[int, int]]]:
    """Return panels of three sides: from above, and beside it (in a column below it) from the front and the side."""
    if sheet.wide:
        sheet.tall(104)
        places = sheet.add_gridspec(2, 2, width_ratios=[1, 1])
        axes = [sheet.add_subplot(places[:, 0]), sheet.add_subplot(places[0, 1]), sheet.add_subplot(places[1, 1])]
    else:
        sheet.tall(min(112 + 2 * max(70 * flat, 24), 230))
        axes = list(sheet.subplots(3, 1, height_ratios=[1, max(flat, 0.3), max(flat, 0.3)]))
    return list(zip(axes, ((0, 1), (0, 2), (1, 2)), strict=True))

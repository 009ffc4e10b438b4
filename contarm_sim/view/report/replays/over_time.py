"""Figures of a replay over its samples: coordinates of the last marker, and errors."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.identify.replays.replay import Replay
from contarm_sim.view.colours import BLACK, ERROR, GREEN, LIMIT, MEASURED, PURPLE, SIMULATED, SKY
from contarm_sim.view.report.headline import near
from contarm_sim.view.report.outliers import outliers, reach, told, without
from contarm_sim.view.report.replays.course import Course, broken, course_of
from contarm_sim.view.report.replays.words import millimetres
from contarm_sim.view.sections import dashes, section_hex
from contarm_sim.view.style import Sheet

MM = 1e3

_MOST_NAMES, _MOST_BLOCKS = 14, 30
"""Most blocks with their names above a figure, and most blocks that have a row."""

_MOST_LETTERS = 22

_MARKERS = (BLACK, GREEN, PURPLE, SKY)
"""Of errors of markers: unlike those of what was measured and simulated."""


def draw_components(sheet: Sheet, replay: Replay) -> None:
    """Draw the coordinates of the last marker, measured and simulated, with the 95 % band if there is one."""
    sheet.tall(118 if sheet.wide else 200)
    course, marker = course_of(replay), replay.recording.rig.markers[-1].name
    real, own = MM * replay.recording.positions[:, -1], MM * replay.predicted[:, -1]
    every = sheet.subplots(*((3, 2) if sheet.wide else (6, 1)), sharex=True)
    panels, off = (every[:, 0], every[:, 1]) if sheet.wide else (every[:3], every[3:])
    far = outliers(replay.distance)[:, -1]
    most = 1.08 * float(np.nanmax(np.abs(real - own)[~far], initial=0.0)) or 1.0
    for k, ax in enumerate(off):
        if replay.bands is not None:
            places, half = broken(MM * replay.bands.half_width[:, -1, k], course)
            ax.fill_between(places, -half, half, color=SIMULATED, alpha=0.22, linewidth=0, label="95 % band")
            most = max(most, 1.08 * float(np.nanmax(half)))
        ax.axhline(0, color=SIMULATED, linewidth=0.8)
        ax.plot(course.places, (real - own)[:, k], "o", color=MEASURED, markersize=_dot(len(replay)), markeredgewidth=0)
        ax.set_ylabel(f"{'xyz'[k]}, measured −\nsimulated [mm]")
    for ax in off:
        ax.set_ylim(-most, most)
    for k, ax in enumerate(panels):
        places, line = broken(own[:, k], course)
        ax.plot(course.places, real[:, k], "o", color=MEASURED, markersize=_dot(len(replay)), markeredgewidth=0,
                label="measured")  # fmt: skip
        ax.plot(places, line, color=SIMULATED, linewidth=0.8, label="simulated")
        ax.set_ylabel(f"{'xyz'[k]} [mm]")
    _blocks(panels, replay, course)
    _blocks(off, replay, course, named=False)
    for ax in (panels[-1], off[-1]) if sheet.wide else off[-1:]:
        ax.set_xlabel(course.name)
    off[-1].set_xlim(*_ends(course))
    handles, labels = (a + b for a, b in zip(*(ax.get_legend_handles_labels() for ax in (panels[0], off[0])),
                                             strict=True))  # fmt: skip
    sheet.legend(handles, labels, loc="outside lower center", ncols=3)
    sheet.align_ylabels()
    beyond = f"; {told(int(far.sum()))} beyond" if far.any() else ""
    sheet.heading(f"{marker[:1].upper()}{marker[1:]}: measured and simulated{beyond}")


def draw_errors(sheet: Sheet, replay: Replay) -> None:
    """Draw the error of each marker over the samples, and its spread in each block."""
    blocks = {name: found for name, found in replay.by_block().items() if found.count}
    worst = sorted(blocks, key=lambda name: -blocks[name].median)[:_MOST_BLOCKS]
    kept = [name for name in blocks if name in worst]
    rows = 4.2 * len(kept) + 14
    sheet.tall(62 + rows)
    over, ax = sheet.subplots(2, 1, height_ratios=[46, rows])
    course, markers = course_of(replay), replay.recording.rig.markers
    far, (top, count) = outliers(replay.distance), reach(MM * replay.distance)
    for k, marker in enumerate(markers):
        colour = _MARKERS[k % len(_MARKERS)]
        over.plot(*broken(MM * np.where(far, np.nan, replay.distance)[:, k], course), color=colour, linewidth=0.9,
                  linestyle=dashes(k % 4), label=marker.name)  # fmt: skip
        beyond = course.places[far[:, k]]
        if len(beyond):  # what is empty and not clipped spoils the layout
            over.plot(beyond, np.full(len(beyond), top), "^", color=colour, markersize=4, clip_on=False)
    over.set(xlabel=course.name, ylabel="error [mm]", xlim=_ends(course))
    over.set_ylim(0, top)
    _blocks([over], replay, course, named=False)
    if len(markers) > 1:
        over.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(markers))
    for place, name in enumerate(kept):
        own = MM * np.where(far, np.nan, replay.distance)[replay.recording.blocks == name]
        low, middle, high = np.percentile(own[np.isfinite(own)], (5, 50, 95))
        ax.barh(place, high - low, 0.55, left=low, color=SIMULATED, alpha=0.3, linewidth=0,
                label=None if place else "5 to 95 % of a block")  # fmt: skip
        ax.vlines(middle, place - 0.28, place + 0.28, color=SIMULATED, linewidth=2.0, label=None if place else "median")
        ax.plot(np.sqrt(np.nanmean(own**2)), place, "D", color=ERROR, markersize=3.2,
                label=None if place else "rms without outliers" if count else "rms")  # fmt: skip
    ax.set_yticks(range(len(kept)), [_short(name) for name in kept])
    ax.set_ylim(len(kept) - 0.4, -0.6)
    ax.set_xlim(left=0)
    ax.set_xlabel("error [mm]")
    ax.grid(visible=False, axis="y")
    sheet.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    some = f"; the {len(kept)} worst of {len(blocks)} blocks" if len(kept) < len(blocks) else ""
    found = replay.differences()
    of_length = near(100 * found.median / replay.arm.length)
    outside = f"; {told(count)} beyond (triangles)" if count else ""
    sheet.heading(
        f"Errors: median {millimetres(found.median)} mm, {of_length} % of length{outside if sheet.wide else ''}{some}"
    )


def draw_histogram(sheet: Sheet, replay: Replay) -> None:
    """Draw how often errors have which size, and how their components are spread."""
    sheet.tall(66 if sheet.wide else 118)
    size, parts = sheet.subplots(*((1, 2) if sheet.wide else (2, 1)))
    found, distance = replay.differences(), MM * replay.distance
    known = distance[np.isfinite(distance)]
    far, (most, count) = outliers(known), reach(known)
    bins = min(60, max(10, 2 * int(np.sqrt(len(known)))))
    size.hist(np.minimum(known, 0.999 * most), bins=np.linspace(0, most, bins + 1), color=SIMULATED, alpha=0.45)
    rms = without(replay.distance)
    marks = (("median", found.median, "-"), ("95 %", found.percentile_95, (0, (4, 2))),
             ("rms without outliers" if count else "rms", rms, ":"))  # fmt: skip
    for name, value, look in marks:
        size.axvline(
            MM * value,
            ymax=0.74,
            color=ERROR,
            linewidth=1.0,
            linestyle=look,
            label=f"{name}: {millimetres(value)} mm",
        )
    size.set(xlabel=f"error [mm]; the last bin has {told(count)}" if count else "error [mm]", ylabel="markers",
             xlim=(0, most))  # fmt: skip
    size.set_ylim(top=1.35 * size.get_ylim()[1])  # the legend's room, which lines leave free
    size.legend(loc="upper right")
    error = MM * replay.error.reshape(-1, 3)
    error = error[np.isfinite(error).all(axis=1)][~far]
    ends = 1.08 * float(np.abs(error).max(initial=0.0)) or 1.0
    looks: tuple[Any, ...] = ("-", (0, (4, 1.5)), (0, (1, 1)))
    for k in range(3):
        words = f"{'xyz'[k]}: bias {millimetres(float(error[:, k].mean()) / MM)} mm"
        parts.hist(error[:, k], bins=np.linspace(-ends, ends, bins + 1), histtype="step", color=section_hex(k),
                   linestyle=looks[k], linewidth=1.2, label=words)  # fmt: skip
    parts.axvline(0, ymax=0.66, color=LIMIT, linewidth=0.8)
    parts.set(xlabel="measured less simulated [mm]", ylabel="markers", xlim=(-ends, ends))
    parts.set_ylim(top=1.52 * parts.get_ylim()[1])
    parts.legend(loc="upper left")
    sheet.heading(f"Sizes of the errors, and their components{'; bias without outliers' if count else ''}")


def _blocks(panels: Any, replay: Replay, course: Course, named: bool = True) -> None:
    """Draw a line where one block ends and the next begins, and name the blocks above the first panel, if few."""
    if not 1 < len(course.parts) <= 60:
        return
    for part in course.parts[1:]:
        for ax in panels:
            ax.axvline(course.places[part.start], color=LIMIT, linewidth=0.5, alpha=0.6)
    names = [str(replay.recording.blocks[part.start]) for part in course.parts]
    room = 44  # letters in a row
    if not named or len(names) > _MOST_NAMES or sum(len(name) + 2 for name in names) > room:
        return
    for part, name in zip(course.parts, names, strict=True):
        middle = 0.5 * (course.places[part.start] + course.places[part.stop - 1])
        panels[0].annotate(name, (middle, 1), xycoords=("data", "axes fraction"), xytext=(0, 3), ha="center",
                           va="bottom", textcoords="offset points", color=LIMIT)  # fmt: skip


def _ends(course: Course) -> tuple[float, float]:
    rim = 0.01 * max(float(course.places[-1] - course.places[0]), 1e-9)
    return float(course.places[0]) - rim, float(course.places[-1]) + rim


def _dot(count: int) -> float:
    return 3.0 if count < 100 else 2.0 if count < 500 else 1.3


def _short(name: str) -> str:
    return name if len(name) <= _MOST_LETTERS else f"{name[: _MOST_LETTERS - 1]}…"

"""How large errors are by marker and by block, what was fitted beside what was held out."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.identify.fitted import Left
from contarm_sim.view.colours import BLUE, NOTE, ORANGE
from contarm_sim.view.report.fits.left_over import (
    FITTED,
    HELD_OUT,
    blocks,
    cleaned,
    distances,
    parts,
    repeatability,
    rms,
)
from contarm_sim.view.report.fits.words import millimetres
from contarm_sim.view.report.outliers import outliers, told
from contarm_sim.view.style import INCH, Sheet

LOOKS = {FITTED: {"color": BLUE}, HELD_OUT: {"color": ORANGE, "hatch": "////", "edgecolor": "white"}}
"""Bars of what was fitted and held out."""

_NAMED = 5.0
"""Blocks are named where each has so many millimetres, else numbered."""


def draw_blocks(sheet: Sheet, left: Left) -> None:
    """Draw the rms of the errors by block in their order, and by marker."""
    limit, far = repeatability(left), int(outliers(distances(left)).sum())
    left = cleaned(left)
    markers = left.recording.rig.markers
    every = [(name, rms(left, rows), held) for name, rows, held in blocks(left)]
    several = len(markers) > 1
    room = 1.5 * max(len(name) for name, *_ in every)
    sheet.tall(min(70 + room, 110) + (46 if several else 0))
    rows: Any = sheet.subplots(1 + several, 1, squeeze=False, height_ratios=[1.3, 1][: 1 + several])[:, 0]
    ax = rows[0]
    for part, held in ((FITTED, False), (HELD_OUT, True)):
        own = [(k, 1e3 * size.rms) for k, (_, size, is_held) in enumerate(every) if is_held == held and size]
        if own:
            ax.bar(*zip(*own, strict=True), width=0.8, label=part, linewidth=0, **LOOKS[part])
    width = INCH * sheet.get_figwidth() - 16
    ax.set_xlim(-0.6, len(every) - 0.4)
    if width / len(every) >= _NAMED:
        ax.set_xticks(range(len(every)), [name for name, *_ in every],
                      rotation=90 if room + 2 > width / len(every) else 0)  # fmt: skip
        ax.tick_params(axis="x", length=0)
    ax.set_xlabel("block, in the order of the recording")
    ax.set_ylabel("error, rms [mm]")
    ax.grid(axis="x", visible=False)
    if limit:
        ax.axhline(1e3 * limit[0], color=NOTE, linewidth=1.1, linestyle=(0, (4, 2)),
                   label=f"same command repeats to {millimetres(limit[0])} mm")  # fmt: skip
    handles, labels = ax.get_legend_handles_labels()
    handles, labels = (
        [*handles[bool(limit) :], *handles[: bool(limit)]],
        [*labels[bool(limit) :], *labels[: bool(limit)]],
    )
    if several:
        _markers(rows[1], left)
    sheet.legend(handles, labels, loc="outside lower center", ncols=3 if sheet.wide else 2)
    worst = max(((name, size.rms) for name, size, _ in every if size), key=lambda pair: pair[1])
    sheet.heading(f"Errors by block{' and by marker' if several else ''}; largest in {worst[0]}, "
                  f"{millimetres(worst[1])} mm rms"
                  f"{f' without {told(far)}' if far and sheet.wide else ''}")  # fmt: skip


def _markers(ax: Any, left: Left) -> None:
    markers, chosen = left.recording.rig.markers, parts(left)
    width = 0.8 / len(chosen)
    for place, (part, rows) in enumerate(chosen.items()):
        sizes = [rms(left, rows, k) for k in range(len(markers))]
        at = np.arange(len(markers)) + width * (place - 0.5 * (len(chosen) - 1))
        ax.bar(at, [1e3 * size.rms if size else 0.0 for size in sizes], width=0.92 * width, linewidth=0, **LOOKS[part])
    ax.set_xticks(range(len(markers)), [f"{marker.name}\nat {marker.xi:.2g} of length" for marker in markers])
    ax.tick_params(axis="x", length=0)
    ax.set_ylabel("error, rms [mm]")
    ax.set_xlabel("marker")
    ax.grid(axis="x", visible=False)

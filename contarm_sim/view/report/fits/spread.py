"""How errors are distributed, how they grow with the command, and which way the command went."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from contarm_sim.identify.fitted import Fit, Left
from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.colours import BLUE, GREEN, NOTE, ORANGE, PURPLE
from contarm_sim.view.report.fits.bars import LOOKS
from contarm_sim.view.report.fits.left_over import Hysteresis, distances, driven, hysteresis, parts, repeatability, rms
from contarm_sim.view.report.fits.over_time import COLOURS, MARKS
from contarm_sim.view.report.fits.standings import AGREE
from contarm_sim.view.report.fits.words import millimetres
from contarm_sim.view.report.outliers import reach, told
from contarm_sim.view.report.sweeps.ticks import name_numbers
from contarm_sim.view.style import Sheet

_CHANNELS = 9
"""At most so many channels are drawn: those of the largest gaps."""

_WAYS = (("growing", GREEN, "o", "-"), ("falling", PURPLE, "v", (0, (4, 2))))


def draw_distribution(sheet: Sheet, left: Left) -> None:
    """Draw how errors are distributed, in shares of the samples, beside what the same command repeats to."""
    ax: Any = sheet.subplots()
    sizes = 1e3 * distances(left)
    most, beyond = reach(sizes)
    edges, chosen = np.linspace(0, most, 31), parts(left)
    for place, (part, rows) in enumerate(chosen.items()):
        own = sizes[rows][np.isfinite(sizes[rows])]
        share = 100 * np.histogram(np.minimum(own, most * 0.999), edges)[0] / len(own)
        found = rms(left, rows)
        assert found is not None
        label = f"{part}: median {millimetres(found.median)}, rms {millimetres(found.rms)} mm"
        if place == 0:
            ax.stairs(share, edges, fill=True, color=LOOKS[part]["color"], alpha=0.45, label=label)
        else:
            ax.stairs(share, edges, color=LOOKS[part]["color"], linewidth=1.8, label=label)
        ax.axvline(1e3 * found.median, color=COLOURS[part], linewidth=1.2, linestyle=("-", (0, (5, 2)))[place])
    limit = repeatability(left)
    if limit:
        of = f" rms ({limit[1]:,} times)" if sheet.wide else ""
        label = f"same command repeats to {millimetres(limit[0])} mm{of}"
        ax.axvline(1e3 * limit[0], color=NOTE, linewidth=1.4, linestyle=":", label=label)
    ax.set_xlim(0, most)
    ax.set_ylim(bottom=0)
    ax.set_xlabel(f"error [mm]; the last bin has {told(beyond)} beyond" if beyond else "error [mm]")
    ax.set_ylabel("share of the samples [%]")
    handles, labels = ax.get_legend_handles_labels()
    sheet.legend(handles, labels, loc="outside lower center", ncols=2 if sheet.wide else 1)
    sheet.tall(84 if sheet.wide else 74)
    note = "" if limit else "; no command comes twice, so that repeatability is not known"
    sheet.heading(f"Sizes of the errors; vertical lines are their medians{note if sheet.wide else ''}")


def draw_by_command(sheet: Sheet, left: Left) -> None:
    """Draw errors over the size of the command."""
    found = driven(left)
    assert found is not None
    ax: Any = sheet.subplots()
    sheet.tall(84 if sheet.wide else 74)
    size = np.sqrt((found.values**2).sum(axis=1))
    own = distances(left)
    count = np.isfinite(own).sum(axis=1)
    sizes = 1e3 * np.sqrt(np.nansum(own**2, axis=1) / np.where(count, count, np.nan))
    most, beyond = reach(sizes)
    for part, rows in parts(left).items():
        ax.plot(size[rows], sizes[rows], MARKS[part], color=COLOURS[part], markersize=2.2, alpha=0.5, label=part,
                rasterized=True)  # fmt: skip
    middles, medians = _medians(size, sizes)
    ax.plot(middles, medians, "-", color="black", linewidth=1.6, label="median of all")
    ax.set_ylim(0, most)
    ax.set_xlabel(f"size of the command: {found.word}s, root of the sum of squares [{found.unit}]" if sheet.wide else
                  f"size of the command [{found.unit}]")  # fmt: skip
    ax.set_ylabel("error [mm]")
    handles, labels = ax.get_legend_handles_labels()
    sheet.legend(handles, labels, loc="outside lower center", ncols=3, markerscale=2)
    sheet.heading(f"Errors by the size of the command{f'; {told(beyond)} beyond' if beyond else ''}")


def _medians(across: Array, values: Array) -> tuple[Array, Array]:
    known = np.isfinite(values)
    edges = np.quantile(across[known], np.linspace(0, 1, min(12, max(known.sum() // 10, 2))))
    rows = [known & (across >= a) & (across <= b) for a, b in itertools.pairwise(edges)]
    return 0.5 * (edges[1:] + edges[:-1]), np.array([np.median(values[own]) if own.any() else np.nan for own in rows])


def draw_history(sheet: Sheet, left: Left, noise: float) -> None:
    """Draw the error along the way that each channel moves the last marker, by which way the command went.

    Args:
        sheet: to draw on.
        left: errors of a recording.
        noise: of a coordinate [m]: no gap below is called hysteresis.
    """
    found = driven(left)
    assert found is not None
    every = [(number, hysteresis(left, found, place)) for place, number in enumerate(found.channels)]
    known = [(number, one) for number, one in every if one is not None]
    known.sort(key=lambda pair: -np.nan_to_num(abs(pair[1].gap)))
    shown = sorted(known[:_CHANNELS], key=lambda pair: pair[0])
    beside = min(len(shown), 3 if sheet.wide else 2)
    rows = -(-len(shown) // beside)
    sheet.tall((30 if sheet.wide else 40) + (46 if rows > 1 else 56) * rows * (1 if sheet.wide else 0.82))
    panels: Any = sheet.subplots(rows, beside, squeeze=False, sharex=True, sharey=True)
    most = max(reach(np.abs(1e3 * one.along))[0] for _, one in shown)
    for ax, (number, one) in zip(panels.flat, shown, strict=False):
        _way(ax, one)
        gap = "" if np.isnan(one.gap) else f": {'gap ' if sheet.wide else ''}{1e3 * one.gap:.2f} mm"
        gap = gap.replace("-", "\N{MINUS SIGN}")
        ax.xaxis.set_tick_params(labelbottom=True)
        ax.set_title(f"channel {number}{gap}")
    panels[0, 0].set_ylim(-most, most)
    for ax in panels.flat[len(shown) :]:
        ax.set_axis_off()
    for ax in panels[:, 0]:
        ax.set_ylabel("error along\nthe motion [mm]")
    for column in range(beside):
        last = max(row for row in range(rows) if row * beside + column < len(shown))
        panels[last, column].set_xlabel(f"{found.word} [{found.unit}]")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    sheet.legend(handles, labels, loc="outside lower center", ncols=4 if sheet.wide else 2, markerscale=2)
    left_out = len(known) - len(shown)
    more = f"; {left_out} more have smaller gaps" if left_out else ""
    largest = max((abs(one.gap) for _, one in known if np.isfinite(one.gap)), default=0.0)
    if largest <= noise:
        said = f"No hysteresis above the noise of {millimetres(noise)} mm"
    else:
        said = f"Hysteresis up to {millimetres(largest)} mm"
    gap = ": gaps of medians, growing less falling" if sheet.wide else ""
    sheet.heading(f"{said}{gap}{more if sheet.wide else ''}")


def _way(ax: Any, one: Hysteresis) -> None:
    for place, (word, colour, mark, dashes) in enumerate(_WAYS):
        rows = one.growing if place == 0 else one.falling
        ax.plot(one.command[rows], 1e3 * one.along[rows], mark, color=colour, markersize=1.9, alpha=0.4,
                label=f"command {word}", rasterized=True)  # fmt: skip
        ax.plot(one.middles, 1e3 * one.medians[:, place], color=colour, linewidth=1.8, linestyle=dashes,
                label=f"median, {word}", path_effects=_outlined())  # fmt: skip
    ax.axhline(0, color="black", linewidth=0.6)


def _outlined() -> list[Any]:
    """Return what sets a line apart from dots of its colour."""
    from matplotlib.patheffects import Normal, Stroke

    return [Stroke(linewidth=3.4, foreground="white"), Normal()]


def draw_starts(sheet: Sheet, fit: Fit) -> None:
    """Draw what the searches from several starts end at."""
    costs = np.array([cost for cost in fit.cost if np.isfinite(cost)])
    lost = np.arange(len(costs) + 1, len(fit.cost) + 1)
    ax: Any = sheet.subplots()
    sheet.tall(62)
    over = costs / costs.min()
    ax.plot(np.arange(1, len(costs) + 1), over, "o", color=BLUE, markersize=5)
    ax.axhline(1.0, color=NOTE, linewidth=1.0, linestyle=(0, (4, 2)))
    if over.max() > 3:
        ax.set_yscale("log")
        name_numbers(ax.yaxis, over, True, 6)
    else:
        ax.set_ylim(0.99, max(1.1, 1.05 * over.max()))
    if len(lost):
        top = ax.get_ylim()[1]
        ax.plot(lost, np.full(len(lost), top), "x", color=ORANGE, markersize=6, markeredgewidth=1.6, clip_on=False,
                zorder=5, label="without a pose")  # fmt: skip
        sheet.legend(*ax.get_legend_handles_labels(), loc="outside lower center")
    ax.set_xlim(0.5, len(fit.cost) + 0.5)
    ax.xaxis.get_major_locator().set_params(integer=True)
    ax.set_xlabel("start, that of the lowest cost first")
    ax.set_ylabel("cost at its end,\nover the lowest [-]")
    same = int((over <= 1 + AGREE).sum())
    more = f"; {len(lost)} found no pose" if len(lost) else ""
    sheet.heading(f"What {len(fit.cost)} starts end at: {same} within {100 * AGREE:g} % of the lowest cost{more}")

"""The figures of an uncertain arm: tip error as a band and as a distribution, tips in space, causes."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.sweeps.causes import Causes
from contarm_sim.sweeps.spread_of_motion import UncertainMotion
from contarm_sim.sweeps.spread_of_pose import UncertainPose
from contarm_sim.view.colours import BLUE, ERROR, LIMIT, NOTE, SIMULATED, TARGET
from contarm_sim.view.report.shares import draw_shares, name_shares
from contarm_sim.view.report.uncertainty_words import ERRORS
from contarm_sim.view.space import add_space
from contarm_sim.view.stance import stance
from contarm_sim.view.style import Draw, Sheet
from contarm_sim.view.trim import trim

MM = 1e3

_CAUSES = {
    "mean": "tip error, mean over time",
    "max": "tip error, largest",
    "tip": "place of the tip",
    "distance": "distance from the nominal tip",
}
"""What causes are drawn of."""

_BAND: dict[str, Any] = {"color": SIMULATED, "alpha": 0.22, "linewidth": 0}
_MEDIAN: dict[str, Any] = {"color": SIMULATED, "linewidth": 2.4}  # seen on both sides of the nominal arm's line
_NOMINAL: dict[str, Any] = {"color": ERROR, "linewidth": 0.9}
_ELLIPSE: dict[str, Any] = {"color": SIMULATED, "linewidth": 1.0}

_DOTS = 400
"""Most cases that are drawn as dots of a row."""

_FLAT = 1e-4
"""Coordinates with less spread than this share of the largest are not drawn: they are the same in all arms."""


def draw_spread(sheet: Sheet, found: UncertainMotion) -> None:
    """Draw the tip error over time, of the nominal arm and a band of the sampled ones, and its distributions."""
    sheet.tall(112 if sheet.wide else 132)
    over, rows = sheet.subplots(2, 1, height_ratios=[1.35, 1.0])
    time, low, middle, high = found.nominal.time, *(MM * found.band)
    over.fill_between(time, low, high, label="5 to 95 % of the sampled arms", **_BAND)
    over.plot(time, middle, label="their median", **_MEDIAN)
    over.plot(time, MM * found.nominal.tip_error, label="nominal arm", **_NOMINAL)
    over.set(xlabel="time [s]", ylabel="tip error [mm]", xlim=(time[0], time[-1]))
    over.set_ylim(bottom=0)
    values = {name: MM * each[found.good] for name, each in found.quantities.items()}
    _rows(rows, {ERRORS[name]: (each, MM * found.nominal_error[name]) for name, each in values.items()})
    rows.set_xlabel("tip error [mm]")
    rows.set_xlim(left=0)
    handles, labels = over.get_legend_handles_labels()
    handles.append(rows.plot([], [], "o", color=SIMULATED, markersize=2.2, alpha=0.5)[0])
    sheet.legend(handles, [*labels, "one sampled arm"], loc="outside lower center", ncols=4 if sheet.wide else 1)
    held = stance(found.nominal.arm)
    sheet.heading(f"Tip error of {len(values['mean'])} sampled arms, all commanded as the nominal one ({held})")


def _rows(ax: Any, rows: dict[str, tuple[Array, float]]) -> None:
    """Draw a row for each quantity: its cases as dots, 5 to 95 % as a bar, the median, and the nominal value."""
    chance = np.random.default_rng(0)
    for place, (values, nominal) in enumerate(rows.values()):
        low, middle, high = np.percentile(values, (5, 50, 95))
        ax.barh(place, high - low, 0.5, left=low, **_BAND)
        ax.vlines(middle, place - 0.25, place + 0.25, **_MEDIAN)
        dots = values[:_DOTS]
        ax.plot(dots, place + chance.uniform(-0.2, 0.2, len(dots)), "o", color=SIMULATED, markersize=1.8, alpha=0.45,
                markeredgewidth=0)  # fmt: skip
        ax.vlines(nominal, place - 0.38, place + 0.38, **_NOMINAL)
    ax.set_yticks(range(len(rows)), list(rows))
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.grid(visible=False, axis="y")


def draw_spread_in_space(sheet: Sheet, found: UncertainMotion) -> None:
    """Draw the path of the tip of the nominal arm and of some sampled arms, and their backbones at the end."""
    run = found.nominal
    ax = add_space(sheet, run.arm)
    tips = found.tips[found.good][: len(found.bones)]
    said = (f"tips of {len(tips)} sampled arms", "their backbones at the end")
    for number, (path, bones) in enumerate(zip(tips, found.bones, strict=True)):
        for line, colour, words in zip((path, bones[-1]), (SIMULATED, BLUE), said, strict=True):
            ax.trace(line, color=colour, linewidth=0.6, alpha=0.75, label="" if number else words)
    ax.trace(run.target, color=TARGET, linewidth=1.0, linestyle=(0, (4, 2)), label="target")
    ax.trace(run.tip, color=ERROR, linewidth=0.8, label="nominal arm")
    ax.trace(run.stations[-1], color=ERROR, linewidth=0.8)
    ax.settle()
    sheet.heading(f"Tips of arms all commanded as the nominal one, and backbones at the end ({stance(run.arm)})")
    trim(sheet, 110)


def draw_pose_spread(sheet: Sheet, found: UncertainPose) -> None:
    """Draw the tips of the sampled arms around the tip of the nominal one, with the ellipse, in all views that differ.

    Where a coordinate is the same in all arms, as where all bend in one plane, the one view without it is drawn.
    """
    tips = MM * (found.tips[found.good] - found.nominal.tip)
    spread = tips.std(axis=0)
    spread_along = [i for i in range(3) if spread[i] > _FLAT * spread.max()]
    views = list(combinations(spread_along if len(spread_along) == 2 else range(3), 2))
    sheet.tall(86 if len(views) == 1 else 70 if sheet.wide else 178)
    shape = (1, len(views)) if sheet.wide else (len(views), 1)
    panels = sheet.subplots(*shape, squeeze=False).ravel()
    for ax, (i, k) in zip(panels, views, strict=True):
        ax.plot(*tips[:, [i, k]].T, "o", color=SIMULATED, markersize=2.2, alpha=0.5, markeredgewidth=0,
                label="one sampled arm")  # fmt: skip
        around = MM * (found.ellipse(i, k) - found.nominal.tip[[i, k]])
        ax.plot(*around.T, label="95 % ellipse of a fitted normal distribution", **_ELLIPSE)
        ax.plot(0, 0, "+", color=ERROR, markersize=8, markeredgewidth=1.4, label="nominal arm")
        ax.set(xlabel=f"{'xyz'[i]} from nominal tip [mm]", ylabel=f"{'xyz'[k]} from nominal tip [mm]")
        ax.set_aspect("equal", adjustable="datalim")
    sheet.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3 if sheet.wide else 1)
    flat = "" if len(views) > 1 else f"; all have the same {next('xyz'[i] for i in range(3) if i not in views[0])}"
    sheet.heading(f"Tips of {len(tips)} sampled arms, from the nominal arm's tip{flat}")


def draw_causes(sheet: Sheet, found: UncertainMotion | UncertainPose) -> None:
    """Draw what share of the variance each parameter causes, alone and together with others, with 95 % intervals."""
    asked = {name: each for name, each in found.causes.items() if name in _CAUSES}
    names = _by_share(found.uncertain.names, list(asked.values()))
    across = len(asked) if sheet.wide else 1
    height = (13 + 6.5 * len(names)) * (len(asked) // across) + 34
    sheet.tall(max(height, 62))
    panels = sheet.subplots(len(asked) // across, across, sharex=True, sharey=True, squeeze=False).ravel()
    for ax, (name, causes) in zip(panels, asked.items(), strict=True):
        ax.set_title(_CAUSES[name].replace(", ", ",\n" if sheet.wide else ", "))
        _shares(ax, causes, [found.uncertain.names.index(each) for each in names])
    panels[0].set_yticks(range(len(names)), [each.replace("_", " ") for each in names])
    panels[0].set_ylim(len(names) + 0.25, -0.6)  # with a row for words
    panels[0].set_xlim(-0.04, 1.04)
    panels[0].set_xticks([0, 0.5, 1], ["0", "50", "100"])
    for ax in panels if sheet.wide else ():  # "100" and "0" of neighbours would run together
        labels = ax.get_xticklabels()
        labels[0].set_ha("left")
        labels[-1].set_ha("right")
    for ax in panels if sheet.wide else panels[-1:]:
        ax.set_xlabel("share of variance [%]\nbars: 95 % intervals")
    name_shares(sheet, panels[0])
    sheet.heading("Which uncertain parameter causes it: Sobol indices")


def _by_share(names: tuple[str, ...], quantities: list[Causes]) -> list[str]:
    """Return the parameters, those first that cause most of the first quantity that has causes."""
    shares = next((each.total for each in quantities if not each.reason), np.zeros(len(names)))
    return [names[i] for i in np.argsort(-shares, kind="stable")]


def _shares(ax: Any, causes: Causes, order: list[int]) -> None:
    if causes.reason:
        ax.grid(visible=False, axis="y")
        ax.text(
            0.5,
            0.5,
            f"no indices:\n{_broken(causes.reason)}",
            transform=ax.transAxes,
            ha="center",
            va="center",
            color=NOTE,
        )
        return
    draw_shares(ax, causes.first[order], causes.total[order], causes.first_interval[order].T,
                causes.total_interval[order].T)  # fmt: skip
    left = 1 - causes.explained
    ax.annotate(f"unexplained: {100 * left:.2g} %", (1, 0), xycoords="axes fraction", xytext=(-2, 3), ha="right",
                va="bottom", textcoords="offset points", color=LIMIT)  # fmt: skip


def _broken(words: str, width: int = 22) -> str:
    import textwrap

    return textwrap.fill(words, width)


def figures_of_motion(found: UncertainMotion) -> dict[str, Draw]:
    """Return what draws the figures by their names; none of fewer than two results."""
    if found.good.sum() < 2:
        return {}
    return {
        "uncertainty": lambda sheet: draw_spread(sheet, found),
        "uncertain_path": lambda sheet: draw_spread_in_space(sheet, found),
        "causes": lambda sheet: draw_causes(sheet, found),
    }


def figures_of_pose(found: UncertainPose) -> dict[str, Draw]:
    """Return what draws the figures by their names; none of fewer than two results."""
    if found.good.sum() < 2:
        return {}
    return {
        "uncertain_tip": lambda sheet: draw_pose_spread(sheet, found),
        "causes": lambda sheet: draw_causes(sheet, found),
    }

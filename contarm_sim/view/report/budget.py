"""Where a run's tip error comes from, over time: parts along the error, which add up to it, and their sizes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.results.compare import Comparison
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.colours import CONTACT, DISCRETISATION, ERROR, MISS, MOTION, SERVO, SHAPE
from contarm_sim.view.sections import section_look
from contarm_sim.view.stance import stance
from contarm_sim.view.style import Sheet

LEAST = 1e-4
"""Foot of logarithmic axes [mm]."""


@dataclass(frozen=True, eq=False)
class Part:
    """A part of the tip error: what it displaces the tip by [m], shape (K, 3), and how it looks."""

    words: str
    moved: Array
    colour: str
    dashes: Any
    hatch: str


Split = tuple[NDArray[np.intp], list[Part]]
"""Indices of samples, shape (K,), and the parts of the tip error there."""


def parts_of(samples: Trajectory, comparison: Comparison, motion: tuple[Array, Array] | None) -> Split:
    """Return indices of samples, shape (K,), and the parts of the tip error there: together they are its.

    Args:
        motion: what `moved_by_motion` returned. Without it, or where that is not known, motion is part of the shape.
    """
    if motion is not None and not np.isfinite(motion[1]).all():
        motion = None
    index = np.arange(len(samples)) if motion is None else np.searchsorted(samples.time, motion[0])
    alone_tip = comparison.simulated_tip if comparison.alone_tip is None else comparison.alone_tip
    analytic, chain, followed, simulated, alone = (
        tip[index]
        for tip in (
            comparison.analytic_tip, comparison.chain_tip, comparison.followed_tip, comparison.simulated_tip, alone_tip
        )
    )  # fmt: skip
    servo = "servo: commanded vs measured lengths" if samples.holds_lengths else "lengths shifted for the tip"
    shape = alone - followed
    found = [
        Part("discretisation: arc vs links", chain - analytic, DISCRETISATION, (0, (4, 1.5)), ""),
        Part(servo, followed - chain, SERVO, (0, (1, 1)), "...."),
    ]
    look: Any = (SHAPE, (0, (5, 1, 1, 1)), 3 * "\\")
    if motion is None:
        found.append(Part("shape: gravity, inertia, unequal joints", shape, *look))
    else:
        found.append(Part("shape at rest: sag, unequal joints", shape - motion[1], *look))
        found.append(Part("motion: inertia, damping, lag", motion[1], MOTION, (0, (2, 1)), "////"))
    if comparison.alone_tip is not None:
        found.append(Part("contact: with objects vs without", simulated - alone, CONTACT, (0, (6, 1)), "xx"))
    return index, found


def along(moved: Array, error: Array) -> Array:
    """Return the parts of displacements along the error, both of shape (K, 3): shape (K,), below zero if it is less."""
    size = np.linalg.norm(error, axis=-1)
    return np.divide((moved * error).sum(axis=-1), size, out=np.zeros(len(size)), where=size > 0)


def draw_parts(
    sheet: Sheet, samples: Trajectory, comparison: Comparison, motion: tuple[Array, Array] | None = None
) -> None:
    """Draw the tip error over time, and its parts along it, stacked; `motion` as in `parts_of`."""
    sheet.tall(85 if sheet.wide else 92)
    ax = sheet.subplots()
    split = parts_of(samples, comparison, motion)
    handles = _stack(ax, samples, comparison, split)
    ax.set_xlabel("time [s]")
    words = ["tip error: analytic vs simulated", *(part.words for part in split[1])]
    sheet.legend(handles, words, loc="outside lower center", ncols=2 if sheet.wide else 1)
    held = stance(samples.arm)
    sheet.heading(f"Where the tip error comes from ({held}): parts along the error, which add up to it")


def draw_budget(
    sheet: Sheet, samples: Trajectory, comparison: Comparison, motion: tuple[Array, Array] | None = None
) -> None:
    """Draw tip error and its parts, their sizes, and orientation error, over time; `motion` as in `parts_of`.

    Of several sections, also what the tip moves where one section alone has a part.
    """
    from matplotlib.legend_handler import HandlerTuple

    time, several = samples.time, len(samples.arm.sections) > 1
    alone = ["discretisation", "servo", "shape"] if several else []
    rows: list[list[str]] = [["stack"], ["sizes"], *([[name] for name in alone]), ["turn"]]
    heights = [40, 40, *[24] * len(alone), 20]
    if sheet.wide:
        rows = [["stack"] * 3, ["sizes"] * 3, *([alone] if several else []), ["turn"] * 3]
        heights = [40, 40, *([34] if several else []), 22]
    sheet.tall(sum(heights) + (50 if sheet.wide else 66))
    panels: dict[str, Any] = sheet.subplot_mosaic(rows, height_ratios=heights)
    split = parts_of(samples, comparison, motion)
    areas = _stack(panels["stack"], samples, comparison, split)
    lines = _sizes(panels["sizes"], samples, comparison, split)
    words = ["tip error: analytic vs simulated", *(part.words for part in split[1])]
    handles: list[Any] = [lines.pop(0), *zip(areas[1:], lines, strict=False)]
    if len(lines) > len(split[1]):
        words.append(f"miss: target {'out of reach' if several else 'off the dome'}")
        handles.append(lines[-1])
    if several:
        own = _of_sections([panels[name] for name in alone], time, comparison)
        words += [f"section {number + 1} alone" for number in range(len(own))]
        handles += own
        for name in alone:
            panels[name].set_title(name, loc="left")
            panels[name].tick_params(labelleft=not sheet.wide or name == alone[0])
        panels[alone[0 if sheet.wide else 1]].set_ylabel("moved by one\nsection's [mm]")
    panels["turn"].plot(time, np.degrees(comparison.orientation_error), color=ERROR)
    panels["turn"].set_ylabel("orientation\nerror [deg]")
    for name, ax in panels.items():
        ax.sharex(panels["turn"])
        ax.tick_params(labelbottom=name == "turn" or (sheet.wide and name in alone))
    panels["turn"].set_xlabel("time [s]")
    sheet.align_ylabels([ax for name, ax in panels.items() if name not in alone or not sheet.wide])
    sheet.get_layout_engine().set(h_pad=0.06)  # type: ignore[union-attr, call-arg]
    sheet.legend(handles, words, loc="outside lower center", ncols=2 if sheet.wide else 1, handlelength=3.2,
               handler_map={tuple: HandlerTuple(ndivide=2, pad=0.3)})  # fmt: skip
    held, parts = stance(samples.arm), "parts along the error, which add up to it, and sizes of the parts"
    sheet.heading(f"Where the tip error comes from ({held}): {parts}")


def _stack(ax: Any, samples: Trajectory, comparison: Comparison, split: Split) -> list[Any]:
    """Stack parts along the error [mm]: those that add to it above zero, those that take from it below.

    Returns:
        The line of the error, and the areas.
    """
    index, parts = split
    error = (comparison.simulated_tip - comparison.analytic_tip)[index]
    time, above, below = samples.time[index], np.zeros(len(index)), np.zeros(len(index))
    drawn = ax.plot(samples.time, 1e3 * comparison.tip_error, color=ERROR, zorder=3)
    for part in parts:
        own = 1e3 * along(part.moved, error)
        start = np.where(own >= 0, above, below)
        drawn.append(ax.fill_between(time, start, start + own, facecolor=part.colour, hatch=part.hatch,
                                     edgecolor="white", linewidth=0))  # fmt: skip
        above, below = above + np.maximum(own, 0), below + np.minimum(own, 0)
    ax.axhline(0, color=ERROR, linewidth=0.6)
    ax.set_ylabel("tip error and its\nparts along it [mm]")
    _percent(ax, samples.arm.length).set_ylabel("[% of length]")
    return drawn


def _sizes(ax: Any, samples: Trajectory, comparison: Comparison, split: Split) -> list[Any]:
    """Draw sizes of error, parts and, if there is any, miss [mm] on a logarithmic axis; return the lines."""
    from matplotlib.ticker import LogLocator

    (index, parts), time = split, samples.time
    drawn = ax.plot(time, 1e3 * comparison.tip_error, color=ERROR, linewidth=2.6)
    most = comparison.tip_error.max()
    for part in parts:
        size = np.linalg.norm(part.moved, axis=-1)
        most = max(most, size.max())
        drawn += ax.plot(time[index], 1e3 * size, color=part.colour, linestyle=part.dashes, linewidth=1.5)
    if comparison.miss.max() > 1e-6:
        drawn += ax.plot(time, 1e3 * comparison.miss, color=MISS, linestyle=(0, (7, 1.5)), linewidth=1.0)
        most = max(most, comparison.miss.max())
    ax.set_yscale("log")
    ax.set_ylim(LEAST, 2e3 * max(most, 1e-6))
    ax.yaxis.set_major_locator(LogLocator(numticks=5))
    ax.set_ylabel("size of error and\nof parts [mm]")
    _percent(ax, samples.arm.length).set_ylabel("[% of length]")
    return drawn


def _percent(ax: Any, length: float) -> Any:
    """Add an axis on the right that has millimetres in percent of length."""
    return ax.secondary_yaxis("right", functions=(lambda x: x / 10 / length, lambda x: x * 10 * length))


def _of_sections(panels: list[Any], time: Array, comparison: Comparison) -> list[Any]:
    """Draw the three parts of each section alone [mm], on one scale; return a line a section."""
    sizes = [1e3 * of for of in (comparison.section_discretisation, comparison.section_servo, comparison.section_shape)]
    drawn: list[Any] = []
    for ax, own in zip(panels, sizes, strict=True):
        drawn = [ax.plot(time, own[:, number], **section_look(number))[0] for number in range(own.shape[1])]
        ax.set_yscale("log")
        ax.set_ylim(LEAST, 2 * max(float(np.max(sizes)), LEAST))
    return drawn

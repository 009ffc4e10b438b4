"""What commands that are proposed would tell: rows, a sentence, and a figure of what each further pattern adds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from contarm_sim.identify.excite import Excitation
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.view.colours import BLACK, BLUE, FAINT, GREEN, LIMIT, ORANGE, PURPLE, RED, SKY, TARGET
from contarm_sim.view.sections import dashes
from contarm_sim.view.style import Sheet

_LINES = (BLUE, RED, GREEN, ORANGE, PURPLE, SKY, BLACK, TARGET)

MOST = len(_LINES)
"""Most parameters that have a line with a name."""

_SHOWN = {"m": (1e3, "mm"), "Pa": (1e-3, "kPa"), "rad": (math.degrees(1.0), "deg")}
"""What units are shown as, and the factor."""


def parameter_rows(found: Excitation) -> list[list[Any]]:
    """Return a row of each parameter: unit, value, expected standard deviation before and after, their ratio."""
    rows: list[list[Any]] = []
    columns = (found.names, found.units, found.values, found.sd_before, found.sd_after)
    for name, unit, value, before, after in zip(*columns, strict=True):
        times, shown = _SHOWN.get(unit, (1.0, unit))
        lost = [f"{times * sd:.3g}" if math.isfinite(sd) else "not determined" for sd in (before, after)]
        gain = f"{before / after:.3g} times" if math.isfinite(before) and after > 0 else "–"
        rows.append([name, shown.replace("-", "").replace("^2", "²"), f"{times * value:.4g}", *lost, gain])
    return rows


def pattern_rows(found: Excitation) -> list[list[Any]]:
    """Return a row of each chosen pattern: poses, what it tells alone, and how much smaller it makes deviations.

    The last is the geometric mean over the parameters that are determined before and after it.
    """
    rows: list[list[Any]] = []
    for place, number in enumerate(found.chosen):
        name = found.patterns[number]
        before, after = found.steps[place], found.steps[place + 1]
        both = np.isfinite(before) & np.isfinite(after) & (after > 0)
        new = int((np.isfinite(after) & ~np.isfinite(before)).sum())
        share = float(np.exp(np.log(before[both] / after[both]).mean())) if both.any() else math.nan
        said = [] if math.isnan(share) else [f"then shrinks standard deviations by {100 * (1 - 1 / share):.2g} %"]
        said += [f"determines {new} more"] if new else []
        rows.append(
            [name, f"{int((found.blocks == name).sum())}", f"{found.gains[number]:.3g}", ", ".join(said) or "–"]
        )
    return rows


def told(found: Excitation, known: Recording | None) -> str:
    """Say in a few sentences what is gained, and what is not."""
    count = len(found.chosen)
    base = "Without any recording" if known is None else f"Beside {known.name}"
    lost = [name for name, sd in zip(found.names, found.sd_after, strict=True) if not math.isfinite(sd)]
    better = np.isfinite(found.sd_before) & np.isfinite(found.sd_after) & (found.sd_after > 0)
    said = [f"{base}, {count} of {len(found.patterns)} candidates were chosen."]
    if better.any():
        ratio = found.sd_before[better] / found.sd_after[better]
        said.append(f"Standard deviations would be {ratio.min():.3g} to {ratio.max():.3g} times smaller.")
    if lost:
        said.append(f"Not even all of the chosen determine {', '.join(lost)}.")
    if found.refused:
        said.append(f"{len(found.refused)} were refused: the arm has no pose there, or they leave the limits.")
    said.append("Deviations are those of noise alone: what the model lacks comes on top.")
    return " ".join(said)


def draw_gain(sheet: Sheet, found: Excitation) -> None:
    """Draw expected deviations over the number of patterns, and what each candidate tells alone."""
    sheet.tall(84 if sheet.wide else 140)
    panels = sheet.subplots(*((1, 2) if sheet.wide else (2, 1)), width_ratios=[1.25, 1] if sheet.wide else None)
    over, alone = panels
    ends = found.steps[-1]
    order = [k for k in np.argsort(-_drop(found), kind="stable").tolist() if np.isfinite(ends[k]) and ends[k] > 0]
    counts = np.arange(len(found.steps))
    for place, k in enumerate(order):
        line = np.where(np.isfinite(found.steps[:, k]), found.steps[:, k] / ends[k], np.nan)
        named = place < MOST
        look: dict[str, Any] = {"color": _LINES[place], "linestyle": dashes(place % 4)} if named else {"color": FAINT}
        label = found.names[k] if named else "others" if place == MOST else None
        over.plot(
            counts, line, marker="o", markersize=2.4, linewidth=1.0, zorder=2 if named else 1, label=label, **look
        )
    over.axhline(1, color=LIMIT, linewidth=0.6)
    over.set(xlabel="patterns measured", ylabel=f"standard deviation,\nover that after {counts[-1]}", yscale="log")
    over.set_xlim(-0.2, counts[-1] + 0.2)
    over.xaxis.get_major_locator().set_params(integer=True)
    _plain(over)
    gains = found.gains
    ranked = np.argsort(-np.nan_to_num(gains, nan=-1.0), kind="stable")
    ranked = ranked[np.isfinite(gains[ranked])]
    taken = np.isin(ranked, found.chosen)
    places = np.arange(1, len(ranked) + 1)
    alone.bar(places[~taken], gains[ranked[~taken]], width=0.8, color=FAINT, label="candidate")
    alone.bar(places[taken], gains[ranked[taken]], width=0.8, color=BLUE, label="proposed")
    alone.set(
        xlabel="candidates, by what they tell alone", ylabel="information alone [nats]", xlim=(0, len(ranked) + 1)
    )
    alone.set_ylim(0, 1.2 * float(gains[ranked].max(initial=0.0)) or 1.0)
    alone.legend(loc="upper right", ncols=2)
    if order:
        sheet.legend(*over.get_legend_handles_labels(), loc="outside lower center", ncols=2 if sheet.wide else 1)
    sheet.heading("What each further pattern tells")


def _drop(found: Excitation) -> Any:
    """Return how much each parameter's deviation falls from where it is first determined, shape (P,)."""
    first = np.array([next((sd for sd in own if np.isfinite(sd)), np.nan) for own in found.steps.T])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.nan_to_num(first / found.steps[-1], nan=0.0, posinf=0.0)


def _plain(ax: Any) -> None:
    """Write the numbers of a logarithmic axis as they are read: 1, 1.2, 1.5, 2, 3."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low, high = ax.get_ylim()
    firsts: tuple[float, ...] = (1, 1.2, 1.5, 2, 3, 5, 7)
    for finer in ((1, 1.1, 1.2, 1.3, 1.4, 1.5), (1, 1.02, 1.04, 1.06, 1.08, 1.1)):
        if high < 1.1 * finer[-1] and low > 0.5:
            firsts = finer
    marks = [first * 10.0**power for power in range(-2, 9) for first in firsts]
    ax.yaxis.set_major_locator(FixedLocator([mark for mark in marks if low <= mark <= high]))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_locator(NullLocator())

"""What the data tell apart: correlations of the parameters' errors, singular values, and what is not determined."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import colormaps

from contarm_sim.identify.fitted import Fit
from contarm_sim.view.colours import BLUE, FAINT, ORANGE
from contarm_sim.view.style import INCH, LETTERS, Sheet

_NUMBERED = 5.5
"""Cells of fewer millimetres are drawn without numbers."""

_CELL, _ROW, _LETTER = 9.0, 4.4, 1.55
"""Largest cell, lowest row, and width of a letter [mm]."""

_MAP = "RdBu_r"


def draw_correlation(sheet: Sheet, fit: Fit) -> None:
    """Draw the correlations of the errors of those parameters that are determined."""
    kept = np.flatnonzero(np.isfinite(np.diag(fit.correlation)))
    names, matrix = [fit.parameters[k].name for k in kept], fit.correlation[np.ix_(kept, kept)]
    count, lost = len(names), len(fit.parameters) - len(kept)
    room = INCH * sheet.get_figwidth() - _LETTER * (max(map(len, names)) + 3) - 22
    side = min(_CELL, room / count)
    sheet.tall(max(max(side, _ROW) * count, 24) + (26 if sheet.wide else 30))
    ax: Any = sheet.subplots()
    image = ax.imshow(np.ma.masked_invalid(matrix), cmap=_MAP, vmin=-1, vmax=1, aspect="auto")
    numbers = [str(k + 1) for k in range(count)]
    step = max(1, int(np.ceil(4.0 / side)))  # of numbers across; names have a row each
    _frame(ax, numbers, [f"{name}  {number}" for number, name in zip(numbers, names, strict=True)], step)
    if side >= _NUMBERED:
        for i, j in np.argwhere(np.isfinite(matrix)):
            _number(ax, j, i, matrix[i, j])
    bar = sheet.colorbar(image, ax=ax, ticks=[-1, -0.5, 0, 0.5, 1])
    bar.set_label("correlation [-]")
    bar.outline.set_visible(False)
    off = np.abs(matrix - np.diag(np.diag(matrix)))
    if np.isfinite(off).any() and count > 1:
        i, j = sorted(np.unravel_index(np.nanargmax(off), off.shape))
        largest = f"; largest {matrix[i, j]:+.2f}, of {i + 1} and {j + 1}"
    else:
        largest = ""
    more = f"; without {lost} not determined" if lost and sheet.wide else ""
    sheet.heading(f"Correlations of the parameters' errors{largest}{more}")


def _frame(ax: Any, across: list[str], upwards: list[str], step: int = 1) -> None:
    ax.set_xticks(range(0, len(across), step), across[::step])
    ax.set_yticks(range(len(upwards)), upwards)
    ax.tick_params(length=0)
    ax.grid(visible=False)
    ax.set_xticks(np.arange(1, len(across)) - 0.5, minor=True)
    ax.set_yticks(np.arange(1, len(upwards)) - 0.5, minor=True)
    ax.tick_params(which="minor", length=0)
    ax.grid(which="minor", color="white", linewidth=1.2)
    ax.set_axisbelow(False)
    for spine in ax.spines.values():
        spine.set_visible(False)


def _number(ax: Any, x: int, y: int, value: float) -> None:
    red, green, blue, _ = colormaps[_MAP](0.5 + 0.5 * value)
    dark = 0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.45
    text = f"{value:.2f}".replace("-0.00", "0.00").replace("1.00", "1").replace("0.", ".")
    ax.text(x, y, text, ha="center", va="center", color="white" if dark else "black", fontsize=LETTERS)


def draw_singular_values(sheet: Sheet, fit: Fit) -> None:
    """Draw the singular values of the weighted Jacobian, and the directions that the data do not determine."""
    values, lost = np.asarray(fit.singular_values, dtype=float), fit.undetermined
    names = [one.name for one in fit.parameters if any(one.name in each.names for each in lost)]
    sheet.tall(66 + (20 + 7 * len(names) if lost else 0))
    rows: Any = (
        sheet.subplots(2, 1, height_ratios=[46, 7 * len(names) + 4], squeeze=False)[:, 0]
        if lost
        else [sheet.subplots()]
    )
    ax = rows[0]
    known = np.arange(1, len(values) + 1)
    shown = np.maximum(values, max(values.max(initial=1.0) * 1e-12, 1e-300))
    few = len(values) - len(lost)
    ax.vlines(known, shown.min() / 5, shown, color=FAINT, linewidth=1.2)
    ax.plot(known[:few], shown[:few], "o", color=BLUE, markersize=5, label="determined")
    if lost:
        ax.plot(known[few:], shown[few:], "o", color=ORANGE, markerfacecolor="white", markeredgewidth=1.5,
                markersize=5, label="not determined")  # fmt: skip
    ax.set_yscale("log")
    ax.set_ylim(shown.min() / 3, shown.max() * 4)
    ax.set_xlim(0.4, len(values) + 0.6)
    ax.xaxis.get_major_locator().set_params(integer=True)
    ax.set_xlabel(
        "direction of the parameters, the best seen first" if sheet.wide else "direction, the best seen first"
    )
    ax.set_ylabel("how strongly seen,\nrelative to noise [-]")
    if lost:
        sheet.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2)
        _directions(sheet, rows[1], fit, names)
    said = f"; {len(lost)} not seen" if lost else ", all seen"
    sheet.heading(f"How well the data see each of {len(values)} directions of the parameters{said}")


def _directions(sheet: Sheet, ax: Any, fit: Fit, names: list[str]) -> None:
    """Draw which parameters take part in what is not determined: a row a parameter, a column a direction."""
    weights, count = np.zeros((len(names), len(fit.undetermined))), len(fit.singular_values)
    for column, each in enumerate(fit.undetermined):
        for name, weight in zip(each.names, each.weights, strict=True):
            weights[names.index(name), column] = weight
    image = ax.imshow(weights, cmap=_MAP, vmin=-1, vmax=1, aspect="auto")
    numbers = [f"{count - k}" for k in range(len(fit.undetermined))]  # the worst is told first, and is the last above
    _frame(ax, numbers, names)
    for i, j in np.argwhere(weights != 0):
        _number(ax, j, i, weights[i, j])
    ax.set_xlabel("direction that is not determined")
    bar = sheet.colorbar(image, ax=ax, ticks=[-1, 0, 1], aspect=8)
    bar.set_label("share [-]")
    bar.outline.set_visible(False)

"""Which parameter causes how much of a quantity's variance: Sobol's indices with their intervals."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.sweeps.sensitivity import LEVEL, Indices
from contarm_sim.view.colours import BLUE, ORANGE
from contarm_sim.view.report.sweeps.columns import Column
from contarm_sim.view.style import Sheet

_APART = 0.14
"""Marks of a row are so far above and below it [rows]."""

_ALONE: dict[str, Any] = {"marker": "o", "color": BLUE, "linestyle": "none", "markersize": 4.5, "capsize": 2}
_TOTAL: dict[str, Any] = {"marker": "D", "color": ORANGE, "markerfacecolor": "white", "linestyle": "none",
                          "markersize": 4.5, "capsize": 2, "markeredgewidth": 1.3}  # fmt: skip


def draw_indices(sheet: Sheet, found: Indices, value: Column) -> None:
    """Draw first-order and total indices, a row a parameter, that of the largest total first."""
    order = np.argsort(-found.total)
    sheet.tall(32 + 9 * len(order))
    ax: Any = sheet.subplots()
    rows = np.arange(len(order))
    for index, interval, look, shift in (
        (found.first, found.first_interval, _ALONE, -_APART),
        (found.total, found.total_interval, _TOTAL, _APART),
    ):
        apart = np.maximum([index - interval[0], interval[1] - index], 0.0)[:, order]
        ax.errorbar(index[order], rows + shift, xerr=apart, elinewidth=1.1, **look)
    ax.axvline(0.0, color="black", linewidth=0.6)
    names = [Column(found.names[k], "-", order) for k in order]
    ax.set_yticks(rows, [name.wrapped(40 if sheet.wide else 18) for name in names])
    ax.set_ylim(len(order) - 0.5, -0.5)
    ax.set_xlim(right=max(1.0, ax.get_xlim()[1]))
    ax.set_xlabel(f"share of the variance [-]{', ' if sheet.wide else chr(10)}bars: {LEVEL:g} % intervals")
    ax.grid(axis="y", visible=False)
    handles = [ax.errorbar([], [], xerr=[], elinewidth=1.1, **look) for look in (_ALONE, _TOTAL)]
    words = ["caused by the parameter alone (first order)", "together with others, too (total)"]
    sheet.legend(handles, words, loc="outside lower center", ncols=2 if sheet.wide else 1)
    sheet.heading(f"What causes the variance of {value.words}: Sobol's indices from {found.points} points")

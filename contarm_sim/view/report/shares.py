"""The look of Sobol's indices: shares of a variance, alone and with interactions, a row a parameter."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.colours import BLUE, ORANGE
from contarm_sim.view.style import Sheet

_APART = 0.14
"""Marks of a row are so far above and below it [rows]."""

_ALONE: dict[str, Any] = {"marker": "o", "color": BLUE, "linestyle": "none", "markersize": 4.5, "capsize": 2}
_TOTAL: dict[str, Any] = {"marker": "D", "color": ORANGE, "markerfacecolor": "white", "linestyle": "none",
                          "markersize": 4.5, "capsize": 2, "markeredgewidth": 1.3}  # fmt: skip
_WORDS = ("by the parameter alone (first order)", "with its interactions (total)")


def draw_shares(ax: Any, first: Array, total: Array, first_interval: Array, total_interval: Array) -> None:
    """Draw first-order and total indices, shape (d,), with their intervals, (2, d): a row a parameter, from above."""
    rows = np.arange(len(first))
    for index, interval, look, shift in ((first, first_interval, _ALONE, -_APART),
                                         (total, total_interval, _TOTAL, _APART)):  # fmt: skip
        apart = np.maximum([index - interval[0], interval[1] - index], 0.0)
        ax.errorbar(index, rows + shift, xerr=apart, elinewidth=1.1, **look)
    ax.axvline(0.0, color="black", linewidth=0.6)
    ax.grid(axis="y", visible=False)


def name_shares(sheet: Sheet, ax: Any) -> None:
    """Say what the marks are."""
    handles = [ax.errorbar([], [], xerr=[], elinewidth=1.1, **look) for look in (_ALONE, _TOTAL)]
    sheet.legend(handles, list(_WORDS), loc="outside lower center", ncols=2 if sheet.wide else 1)

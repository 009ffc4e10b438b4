"""Which parameter causes how much of a quantity's variance: Sobol's indices with their intervals."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.sweeps.sensitivity import LEVEL, Indices
from contarm_sim.view.report.shares import draw_shares, name_shares
from contarm_sim.view.report.sweeps.columns import Column
from contarm_sim.view.style import Sheet


def draw_indices(sheet: Sheet, found: Indices, value: Column) -> None:
    """Draw first-order and total indices, a row a parameter, that of the largest total first."""
    order = np.argsort(-found.total)
    sheet.tall(32 + 9 * len(order))
    ax: Any = sheet.subplots()
    draw_shares(ax, *(each[..., order] for each in (found.first, found.total, found.first_interval,
                                                    found.total_interval)))  # fmt: skip
    names = [Column(found.names[k], "-", order) for k in order]
    ax.set_yticks(range(len(order)), [name.wrapped(40 if sheet.wide else 18) for name in names])
    ax.set_ylim(len(order) - 0.5, -0.5)
    ax.set_xlim(right=max(1.0, ax.get_xlim()[1]))
    ax.set_xlabel(f"share of the variance [-]{', ' if sheet.wide else chr(10)}bars: {LEVEL:g} % intervals")
    name_shares(sheet, ax)
    sheet.heading(f"What causes the variance of {value.words}: Sobol's indices from {found.points} points")

"""Fitted parameters beside their starts and priors: a row each, with 95 % intervals."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from contarm_sim.identify.fitted import Fit, Parameter
from contarm_sim.model.named import named_parameters
from contarm_sim.view.colours import BLUE, FAINT, NOTE, ORANGE, SKY
from contarm_sim.view.report.fits.words import FOUND, digits, unit_of
from contarm_sim.view.report.sweeps.ticks import name_numbers
from contarm_sim.view.style import Sheet

_Z = 1.96

_LOG = 8.0
"""Factors are drawn on a logarithmic axis if the largest is so many times the smallest: fewer have too few ticks."""

_ROW, _TALL_ROW, _AROUND, _EDGES = 5.6, 8.6, 15.0, 14.0
"""Heights of a row, of one with its value below its name, of what is around a panel, above and below all [mm]."""


def draw_parameters(sheet: Sheet, fit: Fit) -> None:
    """Draw what became of each parameter: positive ones as multiples of their start, others in their units."""
    panels = _panels(fit)
    counts = [len(own) for _, own in panels]
    row = _ROW if sheet.wide else _TALL_ROW
    sheet.tall(_EDGES + (0 if sheet.wide else 8) + sum(_AROUND + row * count for count in counts))
    grid: Any = sheet.subplots(len(panels), 1, squeeze=False, height_ratios=[_AROUND / 2 + row * n for n in counts])
    handles: dict[str, Any] = {}
    for ax, (unit, own) in zip(grid[:, 0], panels, strict=True):
        _panel(ax, unit, own, handles, sheet.wide)
    order = ["value and 95 % interval", "from a bootstrap over blocks", "start", "prior, 95 %", "not determined"]
    named = [name for name in order if name in handles]
    sheet.legend([handles[name] for name in named], named, loc="outside lower center", ncols=5 if sheet.wide else 2)
    lost = sum(one.status not in FOUND for one in fit.parameters)
    more = f"; {lost} of {len(fit.parameters)} not determined" if lost else ""
    sheet.heading(f"Fitted parameters, and what they started from{more}")


_UNEVEN = 0.1
"""Intervals whose middle is further from the value, in their widths, are told by their ends."""

_FACTOR = "times its start [-]"


def _panels(fit: Fit) -> list[tuple[str, list[Parameter]]]:
    """Return parameters that share an axis, by what the axis shows."""
    known, found = named_parameters(fit.arm), dict[str, list[Parameter]]()
    for one in fit.parameters:
        factor = one.name in known and known[one.name].interval(fit.arm)[0] == 0 and one.start > 0
        unit = unit_of(one)[1]
        found.setdefault(_FACTOR if factor else f"value [{unit or '-'}]", []).append(one)
    return list(found.items())


def _panel(ax: Any, unit: str, own: list[Parameter], handles: dict[str, Any], wide: bool) -> None:
    rows = np.arange(len(own))
    scales = [_scale(unit, one) for one in own]
    shown = []
    for row, (one, scale) in enumerate(zip(own, scales, strict=True)):
        shown += _row(ax, row, one, scale, handles)
    if unit == _FACTOR:
        low, high = min(shown, default=1.0), max(shown, default=1.0)
        low, high = min(low, 0.95), max(high, 1.05)
        log = high > _LOG * low
        if log:
            ax.set_xscale("log")
            ax.set_xlim(low / (high / low) ** 0.04, high * (high / low) ** 0.04)
        else:
            ax.set_xlim(low - 0.04 * (high - low), high + 0.04 * (high - low))
        name_numbers(ax.xaxis, np.array(ax.get_xlim()), log, 8 if wide else 4)
    else:
        ax.use_sticky_edges = False
        ax.margins(x=0.04)
        ax.locator_params(axis="x", nbins=8 if wide else 4)
    ax.set_ylim(len(own) - 0.4, -0.6)
    ax.set_yticks(rows, [one.name if wide else f"{one.name}\n{_said(one)}" for one in own])
    ax.set_xlabel(unit)
    ax.grid(axis="y", visible=False)
    if not wide:
        return
    right = ax.secondary_yaxis("right")
    right.set_yticks(rows, [_said(one) for one in own])
    right.tick_params(length=0)
    right.spines["right"].set_visible(False)


def _scale(unit: str, one: Parameter) -> Callable[[float], float]:
    factor = 1 / one.start if unit == _FACTOR else unit_of(one)[0]
    return lambda value: factor * value


def _row(ax: Any, row: int, one: Parameter, scale: Callable[[float], float], handles: dict[str, Any]) -> list[float]:
    """Draw a row; return what must be seen of it."""
    start = scale(one.start)
    seen = [start]
    if one.free.sd is not None:
        mean = one.start if one.free.mean is None else one.free.mean
        ends = [scale(mean - _Z * one.free.sd), scale(mean + _Z * one.free.sd)]
        handles["prior, 95 %"] = ax.barh(row, ends[1] - ends[0], left=ends[0], height=0.62, color=FAINT, alpha=0.75,
                                         linewidth=0, zorder=1)  # fmt: skip
        seen += [max(end, 0.2 * start) if start > 0 else end for end in ends]
    (handles["start"],) = ax.plot(start, row, "|", color=NOTE, markersize=11, markeredgewidth=1.4, zorder=2)
    if one.status not in FOUND:
        (handles["not determined"],) = ax.plot(start, row, marker="$?$", color=ORANGE, markersize=6,
                                               linestyle="none", zorder=4)  # fmt: skip
        return seen
    value, low, high = scale(one.value), scale(one.low), scale(one.high)
    if math.isfinite(one.boot_low) and math.isfinite(one.boot_high):
        ends = [scale(one.boot_low), scale(one.boot_high)]
        handles["from a bootstrap over blocks"] = ax.plot(ends, [row + 0.22] * 2, color=SKY, linewidth=2.6,
                                                          solid_capstyle="butt", zorder=3)[0]  # fmt: skip
        seen += ends
    around = [[max(value - low, 0.0)], [max(high - value, 0.0)]] if math.isfinite(low) and math.isfinite(high) else None
    handles["value and 95 % interval"] = ax.errorbar(
        [value], [row], xerr=around, fmt="o", color=BLUE, markersize=4, capsize=2.5, elinewidth=1.3, zorder=5
    )
    seen += [value, *(end for end in (low, high) if math.isfinite(end))]
    return [x for x in seen if x > 0] if start > 0 else seen


def _said(one: Parameter) -> str:
    """Return the value of a parameter in its unit, or what became of it."""
    if one.status not in FOUND:
        return one.status
    factor, unit = unit_of(one)
    half, lopsided = 0.5 * factor * (one.high - one.low), abs(one.high + one.low - 2 * one.value)
    if lopsided > _UNEVEN * (one.high - one.low):
        spread = f" ({digits(factor * one.low, half)} to {digits(factor * one.high, half)})"
    else:
        spread = f" ± {digits(half, half)}" if math.isfinite(half) else ""
    bound = ", at bound" if one.status == "at bound" else ""
    return f"{digits(factor * one.value, half)}{spread} {unit}".rstrip().replace("-", "\N{MINUS SIGN}") + bound

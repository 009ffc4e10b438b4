"""The validity chart: up to which weight, payload and bend, and from how many links on, arcs may be trusted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.sweeps.validity import Stance, Validity
from contarm_sim.view.colours import ANALYTIC, ERROR, FAINT, NOTE, TRUSTED
from contarm_sim.view.style import Sheet

_FINE = 241
"""Places along each axis that colours and contours are drawn at."""

_WEIGHTS = (0.001, 0.01, 0.1, 1.0, 10.0, 100.0)
_PAYLOADS = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
_BENDS = (1, 2, 5, 10, 20, 50, 100)
"""What is named on the axes: weights over stiffness, payloads over the arm's mass, bends [deg]."""

_LEAST, _NO_LIMIT = 1e-3, 1e3
"""An error, or a bend, that is next to nothing; an error that is beyond all bounds [%]."""

_LINED: dict[str, Any] = {"hatch": "////", "edgecolor": NOTE, "linewidth": 0.0}
"""Where there is no rest there are lines across, so that it is no error in grey either."""

_DOTS: Any = (0, (2, 1.5))
_EXAMPLE: dict[str, Any] = {"color": ANALYTIC, "linestyle": (0, (4, 2)), "linewidth": 1.0}
"""Lines with payload, and that of the example."""

_MEANING = ("m: mass of the arm without payload, L: length, ", "EI: bending stiffness, g: 9.81 m/s²")


class _Scale(NamedTuple):
    """An axis: from its values to even steps in print, and back."""

    even: Callable[[Array], Array]
    back: Callable[[Array], Array]


_KNEE = 0.4
"""A payload counts some 2.5 times as much as the same weight along the arm: below this payload the axis is about
linear, above logarithmic, and contours are about straight."""

_BY_PAYLOAD = _Scale(lambda y: np.log1p(np.maximum(y, 0.0) / _KNEE), lambda u: _KNEE * np.expm1(u))
_BY_LINKS = _Scale(lambda y: np.log(np.maximum(y, _LEAST)), np.exp)


_NAMED, _NAMED_BENDS = (0.1, 0.45, 0.72), (0.15, 0.68, 0.88)
"""Shares of a panel's height at which contours are named, those of small errors below."""


def draw_validity(sheet: Sheet, chart: Validity) -> None:
    """Draw the largest tip error at rest against weight over stiffness: by payload, by bend, and by links.

    A column for each way to stand, a row for each question. All share the axis of weights, so that one arm is one
    vertical line: the example has it.
    """
    sheet.heading(
        "When may I trust constant curvature? Find your arm on the lowest axis and go up: "
        "how far is its tip at rest from the arc's, at most?"
    )
    sheet.tall(184 if sheet.wide else 200)
    panels: Any = sheet.subplots(3, len(chart.stances), sharex=True, sharey="row", squeeze=False)
    for column, stance in enumerate(chart.stances):
        _payloads(panels[0, column], chart, stance, sheet.wide)
        _bends(panels[1, column], chart, column, sheet.wide)
        _links(panels[2, column], chart, stance)
        panels[0, column].set_title(stance.meaning, fontweight="bold")
        words = ": weight of the arm over its stiffness" if sheet.wide else ""
        panels[2, column].set_xlabel(f"m g L²/EI{words}")
    for ax in panels.flat:
        ax.set(xscale="log", xlim=(chart.weight[0], chart.weight[-1]))
        ax.grid(True, color=NOTE, alpha=0.25)
        ax.set_axisbelow(False)
        ax.axvline(chart.example, **_EXAMPLE)
    weights = [weight for weight in _WEIGHTS if chart.weight[0] <= weight <= chart.weight[-1]]
    panels[0, 0].set_xticks(weights, [f"{weight:g}" for weight in weights])
    asked = f"bends to {chart.max_bend_deg:g}°"
    panels[0, 0].set_ylabel(f"payload / mass of the arm\n({chart.usual_links} links, {asked})")
    panels[1, 0].set_ylabel(f"bend angle [deg]\n({chart.usual_links} links)")
    panels[2, 0].set_ylabel(f"links\n(no payload, {asked})")
    _legend(sheet, chart)


def _payloads(ax: Any, chart: Validity, stance: Stance, wide: bool) -> None:
    errors = stance.error_percent[:, :, chart.usual]
    _map(ax, chart, chart.payload, errors, _BY_PAYLOAD)
    named = [payload for payload in _PAYLOADS if payload <= chart.payload[-1] * 1.001]
    ax.set_yticks(named, [f"{payload:g}" for payload in named])
    example = float(np.exp(np.interp(np.log(chart.example), np.log(chart.weight), np.log(errors[:, 0]))))
    _read(ax, chart, 0.0, f"{example:.2g} %" if np.isfinite(example) else "no rest", wide)


def _links(ax: Any, chart: Validity, stance: Stance) -> None:
    _map(ax, chart, chart.links.astype(float), stance.error_percent[:, 0, :], _BY_LINKS)
    ax.set_yticks(chart.links, [f"{count:g}" for count in chart.links])


def _map(ax: Any, chart: Validity, y: Array, error: Array, scale: _Scale) -> None:
    """Draw errors [%], shape (X, Y), by weight and by what is upwards."""
    x, even = np.log(chart.weight), scale.even(y)
    fine_x, fine_y = np.linspace(x[0], x[-1], _FINE), np.linspace(even[0], even[-1], _FINE)
    known = np.log(np.where(np.isfinite(error), np.maximum(error, _LEAST), np.nan))
    shown = _between(even, _between(x, known, fine_x).T, fine_y)
    across, upwards, levels = np.exp(fine_x), scale.back(fine_y), np.log(chart.bounds)
    ax.set_facecolor(TRUSTED[-1])
    ax.contourf(across, upwards, shown, levels=[np.log(_LEAST) - 1, *levels, np.log(_NO_LIMIT)], colors=TRUSTED)
    ax.contour(across, upwards, shown, levels=levels, colors=ERROR, linestyles="-", linewidths=_widths(chart))
    inside = np.ones_like(shown)
    if not np.isfinite(error).all():
        inside = _interpolated(even, np.array([_inside(x, column, fine_x) for column in np.isfinite(error).T]), fine_y)
        lost = ax.contourf(across, upwards, inside, levels=[-_NO_LIMIT, 0.0], colors=[FAINT], zorder=3)
        lost.set(**_LINED)
    ax.set_yscale("function", functions=scale)
    ax.set_ylim(y[0], y[-1])
    ax.minorticks_off()
    for bound, level, share in zip(chart.bounds, levels, _NAMED, strict=True):
        row = round(share * (_FINE - 1))
        _name(ax, bound, across, upwards[row], np.where(inside[row] > 0, shown[row] - level, np.nan))


def _inside(x: Array, rests: NDArray[np.bool_], at: Array) -> Array:
    """Return how far places, shape (K,), are from where rest begins or ends, negative where there is none.

    Args:
        x: logarithms of weights that were tried, shape (M,).
        rests: whether all poses of these have a rest, shape (M,). It ends half-way between two that differ.
    """
    middles = 0.5 * (x[1:] + x[:-1])
    ends = middles[rests[1:] != rests[:-1]]
    if len(ends) == 0:
        ends = np.array([2 * x[0] - x[1], 2 * x[-1] - x[-2]])
    sign = np.where(rests[np.searchsorted(middles, at)], 1.0, -1.0)
    return np.asarray(sign * np.abs(at[:, None] - ends).min(axis=1))


def _interpolated(known_at: Array, known: Array, at: Array) -> Array:
    from scipy.interpolate import interp1d

    return np.asarray(interp1d(known_at, known, axis=0)(at))


def _between(known_at: Array, known: Array, at: Array) -> Array:
    """Return values, shape (A, K), on smooth curves through known ones, shape (M, K), that do not overshoot.

    Beyond the known ones that are finite, they stay as the last of these.
    """
    from scipy.interpolate import PchipInterpolator

    out = np.full((len(at), known.shape[1]), np.nan)
    for column, values in enumerate(known.T):
        rests = np.isfinite(values)
        if rests.sum() >= 2:
            near = np.clip(at, known_at[rests][0], known_at[rests][-1])
            out[:, column] = PchipInterpolator(known_at[rests], values[rests])(near)
        elif rests.any():
            out[:, column] = values[rests]
    return out


def _bends(ax: Any, chart: Validity, number: int, wide: bool) -> None:
    """Draw the largest bends within the bounds: colours and lines without payload, dashes with the arm's own mass."""
    most, stance = chart.max_bend_deg, chart.stances[number]
    ax.set(yscale="log", ylim=(_BENDS[0], most))
    ax.set_facecolor(TRUSTED[-1])
    x, loaded = np.log(chart.weight), _loaded(chart)
    fine = np.linspace(x[0], x[-1], _FINE)
    free, heavy = (_bend_curves(chart, number, payload, fine) for payload in (0, loaded))
    for colour, line in list(zip(TRUSTED, free, strict=False))[::-1]:
        ax.fill_between(np.exp(fine), _LEAST, line, color=colour, linewidth=0)
    rests = np.isfinite(stance.error_percent[:, 0, chart.usual])
    if not rests.all():  # how far rest goes beyond the largest error asked about is not known
        known = np.nan_to_num(free[-1], nan=_LEAST)
        lost = _inside(x, rests, fine) <= 0
        ax.fill_between(np.exp(fine), known, most, where=lost, facecolor=FAINT, zorder=3, **_LINED)
    for i, (bound, width) in enumerate(zip(chart.bounds, _widths(chart), strict=True)):
        for line, dashes in ((free[i], "-"), (heavy[i], _DOTS)):
            seen = np.where(line < 0.999 * most, line, np.nan)
            ax.plot(np.exp(fine), seen, color=ERROR, linewidth=width, linestyle=dashes)
        height = _BENDS[0] * (most / _BENDS[0]) ** _NAMED_BENDS[i]
        _name(ax, bound, np.exp(fine), height, height - free[i])
    read = float(np.interp(np.log(chart.example), fine, free[len(chart.bounds) // 2]))
    if np.isfinite(read):
        _read(ax, chart, max(read, _BENDS[0]), f"{read:.2g}°" if read > _LEAST else "0°", wide)
    ticks = [*(bend for bend in _BENDS if bend < most), most]
    named = [f"{bend:g}" if bend in (_BENDS[0], most) or bend < 0.7 * most else "" for bend in ticks]
    ax.set_yticks(ticks, named)
    ax.minorticks_off()


def _loaded(chart: Validity) -> int:
    """Return which payload is drawn beside none: that nearest to the arm's mass."""
    return 1 + int(np.abs(chart.payload[1:] - 1.0).argmin())


def _bend_curves(chart: Validity, number: int, payload: int, fine: Array) -> list[Array]:
    """Return the largest bend within each bound [deg] at logarithms of weights, `_LEAST` where there is none.

    Each curve begins at the weight at which all bends are within the bound no longer. NaN where it is not known.
    """
    curves, x = [], np.log(chart.weight)
    for i, bound in enumerate(chart.bounds):
        bends = chart.stances[number].bend_deg[:, payload, chart.usual, i]
        first = chart.weight_within(bound, number, payload)
        known = np.isfinite(bends) & ((bends < 0.999 * chart.max_bend_deg) | (first is None))
        places, values = x[known], np.log(np.maximum(bends[known], _LEAST))
        if first is not None and first < chart.weight[-1]:
            before = places > np.log(first)
            places, values = places[before], values[before]
            places, values = np.append(np.log(first), places), np.append(np.log(chart.max_bend_deg), values)
        curve = _between(places, values[:, None], fine)[:, 0]
        if len(places):
            curve = np.where((fine < places[0]) | (fine > places[-1]), np.nan, curve)
        whole = fine <= (np.log(first) if first is not None else -np.inf)
        curves.append(np.where(whole, chart.max_bend_deg, np.exp(curve)))
    return curves


_ROOM = {True: 0.85, False: 0.6}
"""Up to which share of the axis words have room to the right of a mark, on a page and in a column."""


def _read(ax: Any, chart: Validity, y: float, words: str, wide: bool) -> None:
    """Mark what is read off for the example."""
    ax.plot(chart.example, y, "o", color="white", markeredgecolor=ANALYTIC, markeredgewidth=1.4, markersize=5,
            clip_on=False, zorder=7)  # fmt: skip
    right = chart.example < chart.weight[0] ** (1 - _ROOM[wide]) * chart.weight[-1] ** _ROOM[wide]
    at = (5, 7) if right else (0, 9)
    ax.annotate(words, (chart.example, y), xytext=at, textcoords="offset points", va="center", color=ANALYTIC,
                ha="left" if right else "center", fontweight="bold", zorder=7, path_effects=_halo())  # fmt: skip


def _name(ax: Any, bound: float, x: Array, y: float, beyond: Array) -> None:
    """Name a contour at a height, where what is beyond it, at the places x, first becomes positive."""
    crossed = 1 + np.flatnonzero((beyond[:-1] <= 0) & (beyond[1:] > 0))
    if len(crossed) and 0.12 * _FINE < crossed[0] < 0.9 * _FINE:
        ax.text(x[crossed[0]], y, f"{bound:g} %", ha="center", va="center", zorder=6, fontweight="bold",
                path_effects=_halo())  # fmt: skip


def _halo() -> list[Any]:
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=3, foreground="white")]


def _widths(chart: Validity) -> list[float]:
    """Return the widths of contours; that of the middle one is larger."""
    return [1.6 if i == len(chart.bounds) // 2 else 0.9 for i in range(len(chart.bounds))]


def _legend(sheet: Sheet, chart: Validity) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    names = [f"tip within {bound:g} % of length" for bound in chart.bounds]
    handles: list[Any] = [Patch(facecolor=colour, edgecolor=ERROR, linewidth=0.5) for colour in TRUSTED]
    names.append(f"off by more than {chart.bounds[-1]:g} %")
    handles.append(Line2D([], [], color=ERROR, linestyle=_DOTS))
    ratio = chart.payload[_loaded(chart)]
    names.append("with a payload of its own mass" if ratio == 1 else f"with a payload of {ratio:.2g} times its mass")
    handles.append(Line2D([], [], marker="o", markerfacecolor="white", markeredgecolor=ANALYTIC, **_EXAMPLE))
    names.append(f"an example: the paper's arm, {chart.example:.3g}")
    if any(not np.isfinite(stance.error_percent).all() for stance in chart.stances):
        handles.append(Patch(facecolor=FAINT, **_LINED))
        names.append("some bend has no pose at rest:\n" + ",\nor ".join(chart.no_rest))
    meaning = ("" if sheet.wide else "\n").join(_MEANING)
    sheet.legend(handles, names, loc="outside lower center", ncols=3 if sheet.wide else 1, title=meaning,
                 alignment="left")  # fmt: skip

"""A small plot in a corner of the picture that fills up as time passes: drawn once, revealed column by column."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.rendering.caption import font
from contarm_sim.view.rendering.draw import Pixels

LETTERS = 0.0215
"""Size of the letters, in heights of the picture."""

_AHEAD = 0.18
"""Opacity of what is still to come."""

_NOW, EDGE = 90, 150
"""Grey of the line at the present time, and of the card's edge."""

_SWATCH = 1.3
"""Length of a legend's line with its gap, in sizes of the letters."""

_SHADE = 0.35
"""Opacity of a band."""

_INK, _SOFT = "#1C1E22", "#555C68"


@dataclass(frozen=True)
class Curve:
    """A quantity over time, shape (T,), and its colour."""

    values: Array
    colour: str


@dataclass(frozen=True)
class Plot:
    """What a card shows.

    Attributes:
        titles: quantity and unit, in full and shorter: the first that fits is taken.
        course: what the curves are drawn over, shape (T,).
        course_name: what that is, with its unit.
        curves: their values.
        top: the largest value to be shown.
        limits: values to draw a dashed line at, and their names; those far above all curves are left out.
        kind: what the curves are of; nothing is said of them unless given.
        names: colours by the names of what they are of.
        band: what is between two curves, of values of shape (T,), and its colour; or None.
    """

    titles: Sequence[str]
    course: Array
    curves: Sequence[Curve]
    top: float
    course_name: str = "time [s]"
    limits: Sequence[tuple[float, str]] = ()
    kind: str = ""
    names: dict[str, str] = field(default_factory=dict)
    band: tuple[Array, Array, str] | None = None


class Panel:
    """A plot on a pale card with an edge; `size`: width and height [pixels], `letters`: their size [pixels]."""

    def __init__(self, size: tuple[int, int], letters: float, plot: Plot) -> None:
        self._start, self._end = float(plot.course[0]), float(plot.course[-1])
        empty, *_ = _picture(*card(size, letters, plot, curves=False))
        full, (self._left, self._right, self._top, self._bottom), self._names = _picture(*card(size, letters, plot))
        self._full, self._later = full.astype(np.uint8), (empty + _AHEAD * (full - empty)).astype(np.uint8)
        self.gap = size[1] // 13
        self._thick = max(1, round(letters / 12))
        for each in (self._full, self._later):
            edge = max(1, round(letters / 15))
            each[:edge], each[-edge:], each[:, :edge], each[:, -edge:] = (EDGE,) * 4

    @property
    def height(self) -> int:
        """Number of rows that the card takes, with a gap above and below."""
        return self._full.shape[0] + 2 * self.gap

    @property
    def width(self) -> int:
        """Number of columns that the card takes, with a gap on either side."""
        return self._full.shape[1] + 2 * self.gap

    def write(self, image: Pixels, place: float, corner: str) -> None:
        """Draw the card, filled up to a place of the course, into the `left` or `right` lower corner of a picture."""
        height, width = self._full.shape[:2]
        span = max(self._end - self._start, 1e-9)
        now = round(self._left + (self._right - self._left) * (place - self._start) / span)
        gap = self.gap
        left = gap if corner == "left" else image.shape[1] - width - gap
        card = image[image.shape[0] - height - gap : image.shape[0] - gap, left : left + width]
        card[:, :now], card[:, now:] = self._full[:, :now], self._later[:, now:]
        rows = np.arange(self._top, self._bottom)
        for first, last, top, foot in self._names:  # names of limits stay to be read
            if first <= now <= last:
                rows = rows[(rows < top) | (rows > foot)]
        card[rows, max(now - self._thick, 0) : now + 1] = _NOW


def fits(size: tuple[int, int], letters: float, plot: Plot) -> bool:
    """Tell whether a card has room for its shortest title, its legend and its curves."""
    words = [plot.titles[-1], *([_legend_words(plot)] if plot.names else [])]
    swatches = _SWATCH * letters * len(plot.names)
    widest = max(font(letters).getlength(words[0]), font(letters).getlength(words[-1]) + swatches)
    return widest <= size[0] - 1.6 * letters and size[1] >= 9 * letters


def card(size: tuple[int, int], letters: float, plot: Plot, curves: bool = True) -> tuple[Any, Any]:
    """Return matplotlib's figure and axes of a card; sizes in pixels."""
    import matplotlib
    from matplotlib.figure import Figure

    width, height = size
    measure = font(letters).getlength
    title = next((words for words in plot.titles if measure(words) <= width - 1.6 * letters), plot.titles[-1])
    legend = measure(_legend_words(plot)) + _SWATCH * letters * len(plot.names) if plot.names else 0.0
    beside = measure(title) + legend + 3.2 * letters <= width
    head = (2.0 if beside or not legend else 3.3) * letters
    left, right, foot = 3.5 * letters, 1.4 * letters, 3.2 * letters
    with matplotlib.rc_context({"font.family": "DejaVu Sans", "font.size": letters, "mathtext.default": "regular"}):
        fig = Figure(figsize=(width / 72, height / 72), dpi=72, facecolor="white")  # one point is one pixel
        inside = (width - left - right, height - foot - head)
        ax = fig.add_axes((left / width, foot / height, inside[0] / width, inside[1] / height))
        if plot.band is not None and curves:
            low, high, colour = plot.band
            ax.fill_between(plot.course, low, high, color=colour, alpha=_SHADE, linewidth=0)
        for curve in plot.curves if curves else ():
            ax.plot(plot.course, curve.values, color=curve.colour, linewidth=0.11 * letters)
        ax.set_xlim(float(plot.course[0]), float(plot.course[-1]))
        top, crossed = _draw_limits(ax, plot, letters, inside)
        ax.set_ylim(0, top)
        fig.text(0.8 * letters / width, 1 - letters / height, title, color=_INK, va="center")
        if crossed and not legend:
            _name_above(fig, measure(title) + 2 * letters, letters, crossed)
        if legend:
            row = letters if beside else 2.3 * letters
            _draw_legend(fig, width - 0.8 * letters - legend if beside else 0.8 * letters, height - row, letters, plot)
        ax.tick_params(length=0.25 * letters, width=0.06 * letters, pad=0.25 * letters, colors=_INK)
        ax.tick_params(axis="x", pad=0.45 * letters)
        ax.set_xlabel(plot.course_name, labelpad=0.1 * letters, color=_INK)
        ax.locator_params(axis="y", nbins=max(1, min(4, int(inside[1] / (1.35 * letters)))))
        ax.locator_params(axis="x", nbins=max(1, min(6, int(inside[0] / (3 * letters)))))
        for side, spine in ax.spines.items():
            spine.set_visible(side in ("left", "bottom"))
            spine.set_linewidth(0.06 * letters)
    return fig, ax


def _draw_limits(ax: Any, plot: Plot, letters: float, inside: tuple[float, float]) -> tuple[float, str]:
    """Draw lines at limits that curves come near, each with its name off the curves.

    Returns:
        the top of the axes, and a name that has no place there: the head of the card has one if it has no legend.
    """
    left_out = ""
    from matplotlib.patheffects import withStroke

    near = [(limit, name) for limit, name in plot.limits if plot.top > 0.6 * limit]
    height = 1.4 * letters / inside[1]  # of a name, as a share of the axes
    top = max([1.08 * max(plot.top, 1e-9), *(limit / max(1 - height, 0.1) for limit, _ in near)])
    for limit, name in near:
        ax.axhline(limit, color=_SOFT, linewidth=0.07 * letters, linestyle=(0, (5, 3)))
        width = min(1.0, (font(letters).getlength(name) + 0.8 * letters) / inside[0])
        places = [(x, y) for y in (limit / top, limit / top - height) if y >= 0 for x in np.linspace(0, 1 - width, 9)]
        x, y = min(places, key=lambda place: _crowded(plot, top, place[0], place[1], width, height))
        if not plot.names and _crowded(plot, top, x, y, width, height):
            left_out = name
            continue
        ax.text(
            x + 0.4 * letters / inside[0], y + 0.5 * height, name, transform=ax.transAxes, color=_INK, va="center",
            path_effects=[withStroke(linewidth=0.25 * letters, foreground="white")],
        )  # fmt: skip
    return top, left_out


def _name_above(fig: Any, left: float, letters: float, name: str) -> None:
    """Write the name of a limit behind a piece of its line, at the right of a card's head, if it has room there."""
    from matplotlib.lines import Line2D

    width, height = fig.bbox.width, fig.bbox.height
    start = width - 0.8 * letters - font(letters).getlength(name) - 2.6 * letters
    if start < left:
        return
    row, ends = 1 - letters / height, np.array([start, start + 2.1 * letters]) / width
    fig.add_artist(Line2D(ends, [row, row], color=_SOFT, linewidth=0.07 * letters, linestyle=(0, (5, 3))))
    fig.text((start + 2.6 * letters) / width, row, name, color=_INK, va="center")


def _crowded(plot: Plot, top: float, x: float, y: float, width: float, height: float) -> int:
    """Count the samples of curves in a box of the axes, given in shares of them."""
    share = (plot.course - plot.course[0]) / max(float(plot.course[-1] - plot.course[0]), 1e-9)
    inside = (share >= x) & (share <= x + width)
    values = np.array([curve.values for curve in plot.curves]).reshape(len(plot.curves), -1)[:, inside] / top
    return int(np.sum((values >= y - 0.1 * height) & (values <= y + 1.1 * height)))


def _legend_words(plot: Plot) -> str:
    return "  ".join([plot.kind, *plot.names])


def _draw_legend(fig: Any, x: float, y: float, letters: float, plot: Plot) -> None:
    """Write what the curves are of, each name behind a piece of its line; from a place on the card [pixels]."""
    from matplotlib.lines import Line2D

    width, height = fig.bbox.width, fig.bbox.height
    measure = font(letters).getlength
    fig.text(x / width, y / height, plot.kind, color=_INK, va="center")
    x += measure(plot.kind + "  ")
    for name, colour in plot.names.items():
        ends = np.array([x, x + letters]) / width
        fig.add_artist(Line2D(ends, [y / height] * 2, color=colour, linewidth=0.2 * letters, solid_capstyle="butt"))
        x += _SWATCH * letters
        fig.text(x / width, y / height, name, color=_INK, va="center")
        x += measure(name + "  ")


Box = tuple[int, int, int, int]
"""First and last column, first and last row [pixels]."""


def _picture(fig: Any, ax: Any) -> tuple[NDArray[np.float32], Box, list[Box]]:
    """Return the card, shape (height, width, 3), the box of the axes, and those of words in them."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = FigureCanvasAgg(fig)
    canvas.draw()
    picture = np.asarray(canvas.buffer_rgba())[..., :3].astype(np.float32)
    height = picture.shape[0]

    def pixels(box: Any, rim: int = 0) -> Box:
        high, low = height - round(box.y1), height - round(box.y0)
        return round(box.x0) - rim, round(box.x1) + rim, high - rim, low + rim

    names = [pixels(text.get_window_extent(), rim=2) for text in ax.texts]
    return picture, pixels(ax.get_window_extent()), names

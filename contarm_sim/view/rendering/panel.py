"""A small plot in a corner of the picture that fills up as time passes: drawn once, revealed column by column."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.rendering.draw import Pixels

_AHEAD = 0.18
"""Opacity of what is still to come."""

_NOW = 90
"""Grey of the line at the present time."""


@dataclass(frozen=True)
class Curve:
    """A quantity over time, shape (T,), and its colour."""

    values: Array
    colour: str


class Panel:
    """Curves over time on a pale card.

    Args:
        size: width and height [pixels].
        time: [s], shape (T,).
        title: quantity and unit.
        top: the largest value to be shown.
        limit: a value to draw a dashed line at.
        names: colours by the number of the section; nothing is said of them unless given.
    """

    def __init__(
        self, size: tuple[int, int], time: Array, curves: list[Curve], title: str, top: float,
        limit: float | None = None, names: dict[str, str] | None = None,
    ) -> None:  # fmt: skip
        self._start, self._end = float(time[0]), float(time[-1])
        empty, _ = _drawn(size, time, [], title, top, limit, names or {})
        full, (self._left, self._right, self._top, self._bottom) = _drawn(
            size, time, curves, title, top, limit, names or {}
        )
        self._full, self._later = full.astype(np.uint8), (empty + _AHEAD * (full - empty)).astype(np.uint8)

    def write(self, image: Pixels, time: float, corner: str) -> None:
        """Draw the card, filled up to a time [s], into the `left` or `right` lower corner of a picture."""
        height, width = self._full.shape[:2]
        span = max(self._end - self._start, 1e-9)
        now = round(self._left + (self._right - self._left) * (time - self._start) / span)
        gap = height // 12
        left = gap if corner == "left" else image.shape[1] - width - gap
        card = image[image.shape[0] - height - gap : image.shape[0] - gap, left : left + width]
        card[:, :now], card[:, now:] = self._full[:, :now], self._later[:, now:]
        card[self._top : self._bottom, max(now - 1, 0) : now + 1] = _NOW


def _drawn(
    size: tuple[int, int], time: Array, curves: list[Curve], title: str, top: float, limit: float | None,
    names: dict[str, str],
) -> tuple[NDArray[np.float32], tuple[int, int, int, int]]:  # fmt: skip
    """Return the card, shape (height, width, 3), and the columns of first and last time, the rows of top and bottom."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    dpi = 100 * size[1] / 190
    fig = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi, facecolor="white")
    canvas = FigureCanvasAgg(fig)
    ax = fig.add_axes((0.16, 0.2, 0.77, 0.62))
    for curve in curves:
        ax.plot(time, curve.values, color=curve.colour, linewidth=1.6)
    if limit is not None:
        ax.axhline(limit, color="#888888", linewidth=0.9, linestyle="--")
        top = max(top, limit)
    ax.set_xlim(float(time[0]), float(time[-1]))
    ax.set_ylim(0, 1.08 * max(top, 1e-9))
    ax.set_title(title, fontsize=9, loc="left", pad=4)
    ax.tick_params(labelsize=7.5, length=2)
    ax.set_xlabel("time [s]", fontsize=7.5, labelpad=1)
    ax.locator_params(axis="y", nbins=4)
    for place, (name, colour) in enumerate(reversed(names.items())):
        ax.text(1.0 - 0.07 * place, 1.04, name, color=colour, fontsize=9, ha="right", transform=ax.transAxes)
    if names:
        ax.text(
            0.97 - 0.07 * len(names), 1.04, "section", color="#888888", fontsize=8, ha="right", transform=ax.transAxes
        )
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    canvas.draw()
    picture = np.asarray(canvas.buffer_rgba())[: size[1], : size[0], :3].astype(np.float32)
    box = ax.get_window_extent()
    return picture, (round(box.x0), round(box.x1), size[1] - round(box.y1), size[1] - round(box.y0))

"""How figures are made: one style, the widths of a column and of a page, letters of 8 pt, no display, no global state.

A figure is a function that draws on a `Sheet`; `drawn` gives it one, `save` writes what it drew.
"""

from __future__ import annotations

import io
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from contarm_sim.files import appearing
from contarm_sim.view.colours import GRID
from contarm_sim.view.prints import PLAIN, WIDTHS, Prints, Width

INCH = 25.4
SCREEN = 96
"""Pixels of a page in a browser to the inch."""

LETTERS = 8.0
"""Size of all letters [pt]."""

_LETTERS_A_MM = 0.62
"""Letters of that size that fit in a millimetre, about."""

_FINE = 200.0
"""Dots to the inch of files."""

_STYLE = {
    "font.size": LETTERS,
    "axes.titlesize": LETTERS,
    "axes.labelsize": LETTERS,
    "xtick.labelsize": LETTERS,
    "ytick.labelsize": LETTERS,
    "legend.fontsize": LETTERS,
    "legend.title_fontsize": LETTERS,
    "figure.titlesize": LETTERS,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.5,
    "axes.axisbelow": True,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2,
    "legend.borderaxespad": 0.3,
    "lines.linewidth": 1.2,
    "lines.markersize": 3.5,
    "figure.constrained_layout.use": True,
    "figure.constrained_layout.w_pad": 0.02,
    "figure.constrained_layout.h_pad": 0.035,
    "savefig.dpi": _FINE,
    "svg.hashsalt": "contarm",
    "svg.fonttype": "none",  # text stays text: it can be searched and edited
    "pdf.fonttype": 42,
}

_UNDATED: dict[str, dict[str, None]] = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
"""What is left out of files so that the same figure gives the same bytes."""


class Sheet(Figure):
    """What a figure is drawn on: a matplotlib figure of a width in print, 0.6 as tall unless `tall` says otherwise.

    Attributes:
        wide: whether it is as wide as a page; panels that stand beside each other there stand below each other in a
            column.
        titled: whether it has a heading.
    """

    def __init__(self, width: Width = "page", titles: bool = True, **given: Any) -> None:
        size = WIDTHS[width] / INCH
        super().__init__(**{"figsize": (size, 0.6 * size)} | given)
        self.wide, self.titled = width == "page", titles

    def tall(self, height: float) -> None:
        """Set the height [mm]."""
        self.set_figheight(height / INCH)

    def heading(self, words: str) -> None:
        """Write what the figure shows above it, broken into lines that fit; nothing if it is to have no title."""
        if self.titled:
            self.suptitle(textwrap.fill(words, int(_LETTERS_A_MM * INCH * self.get_figwidth())), fontweight="bold")

    def lay_out(self) -> None:
        """Put everything in its place, once: all files show the same, and matplotlib need not draw for it."""
        engine = self.get_layout_engine()
        if engine is not None:
            with rc_context(_STYLE):
                before = self.dpi
                self.set_dpi(_FINE)
                engine.execute(self)
                self.set_dpi(before)
            with rc_context({"figure.constrained_layout.use": False}):
                self.set_layout_engine(None)

    def savefig(self, *given: Any, **named: Any) -> None:
        """Write to a file as every matplotlib figure does, in this style."""
        with rc_context(_STYLE):
            super().savefig(*given, **named)

    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """Return the picture that notebooks show, twice as fine as screens are, and its size [pixels of a page]."""
        picture, (width, height) = io.BytesIO(), self.get_size_inches() * SCREEN
        self.savefig(picture, format="png", dpi=2 * SCREEN)
        return picture.getvalue(), {"width": round(width), "height": round(height)}


Draw = Callable[[Sheet], object]


def drawn(draw: Draw, width: Width = "page", titles: bool = True) -> Sheet:
    """Return a sheet with what a function draws on it."""
    with rc_context(_STYLE):
        sheet = Sheet(width, titles)
        FigureCanvasAgg(sheet)
        draw(sheet)
    return sheet


def save(folder: Path, stem: str, draw: Draw, prints: Prints = PLAIN) -> list[Path]:
    """Write a figure into a folder, each file whole or not at all; return the files.

    Raises:
        OSError: a file cannot be written.
    """
    files = []
    for width, names in prints.names(stem).items():
        sheet = drawn(draw, width, prints.titles)
        for name in names:
            files.append(folder / name)
            with appearing(files[-1]) as scratch:
                write(sheet, scratch)
    return files


def write(sheet: Sheet, path: Path) -> None:
    """Write a sheet into one file, of the kind that its name ends in; the same figure gives the same bytes."""
    kind = path.suffix[1:]
    sheet.lay_out()
    sheet.savefig(path, format=kind, metadata=_UNDATED.get(kind))

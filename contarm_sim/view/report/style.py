"""One publication style for every figure: colour-blind safe, readable in grey, units in every label."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

# Okabe-Ito.
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, BLACK = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000",
)  # fmt: skip

_STYLE = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.4,
    "figure.constrained_layout.use": True,
    "savefig.dpi": 160,
    "svg.hashsalt": "contarm",
    "svg.fonttype": "none",  # text stays text: it can be searched and edited
    "pdf.fonttype": 42,
}

_UNDATED: dict[str, dict[str, None]] = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
"""What is left out of files so that the same figure gives the same bytes."""

Files = Path | Sequence[Path]
"""Where a figure is saved: one file, or several of other kinds."""


@contextmanager
def figure(path: Files, kind: str | None = None, **kwargs: Any) -> Iterator[Any]:
    """Yield a matplotlib figure in the project's style and save it; no display, no global state.

    The kind of file (png, pdf, svg) is that of each path's ending unless given.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context(_STYLE):
        canvas = Figure(**kwargs)
        FigureCanvasAgg(canvas)
        yield canvas
        for one in [path] if isinstance(path, Path) else path:
            canvas.savefig(one, format=kind, metadata=_UNDATED.get(kind or one.suffix[1:]))
            canvas.set_layout_engine("none")  # laid out once: all files show the same

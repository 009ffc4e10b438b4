"""What a colour means, the same in every figure, film, report and page; muscles and sections have their own.

All are told apart by the colour-blind and in grey (Okabe and Ito's set, and violet for what is analytic).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle
from typing import Any, NamedTuple

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.colours import hex_colour

BLUE, ORANGE, GREEN, RED, PURPLE, SKY, BLACK = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000",
)  # fmt: skip

ANALYTIC = "#7529CC"
"""Arcs of constant curvature: ghost, analytic tip, lengths of the arc."""

SIMULATED = RED
"""What the engine found: tip, lengths, poses."""

MEASURED = BLUE
"""What was measured on a real arm: its markers."""

TARGET = "#4D5466"
"""What was asked for: the path, and the target of a moment."""

ERROR = BLACK
"""A line of tip error; where error is told by colour, `error_colours` does it."""

DISCRETISATION, SERVO, SHAPE, MOTION = BLUE, GREEN, ORANGE, PURPLE
"""Parts of the tip error."""

CONTACT = "#E6148C"
"""What the arm touches: links that do, and the forces on them."""

MISS = TARGET
"""How far the target is from where any tip can be."""


class Look(NamedTuple):
    """What tells a line from others: its colour, and for those who do not see that its dashes and marks."""

    colour: str
    dashes: Any
    mark: str


SCENARIOS = {
    "free": Look(BLUE, ":", "o"),
    "ideal": Look(BLUE, ":", "o"),
    "naive": Look(SKY, (0, (7, 1.5)), "s"),
    "gravity": Look(ORANGE, "-", "^"),
    "payload": Look("#7A4300", "--", "v"),
    "upright": Look(GREEN, "-.", "D"),
}
"""Loads and scenarios by their names in studies; `ideal` is `free`."""

THINGS = (
    Look(CONTACT, "-", "o"), Look(BLUE, "--", "s"), Look(BLACK, ":", "^"), Look(GREEN, "-.", "v"),
    Look(ORANGE, (0, (7, 1.5)), "D"), Look("#7A4300", (0, (4, 1.2, 1, 1.2)), "P"),
)  # fmt: skip
"""Objects that are touched, one after the other; with more than six they come again."""

LIMIT = "#777777"
"""Highest and lowest values that are allowed."""

FAINT = "#C8CED6"
"""What is behind: the dome of reachable tips."""

HELD, HELD_EDGE = "#DCE6F2", "#9FB4CC"
"""An area that can be reached or held."""

GRID, PLATE, NOTE = "#E4E4E4", "#9AA0A8", "#555555"
"""Grids of figures, the base's plate in them, and words about a line."""

TRUSTED = ("#FFF4D6", "#FDD48A", "#F59B55", "#C4472E")
"""How far a model is off, in four steps from hardly to too far: light to dark, in grey too."""

DARK_PAGE = "#15171b"
"""What a page is in the dark."""

_ERROR_MAP, _ERROR_START = "YlOrRd", 0.3
"""Yellow would not be seen on white: colours of lines begin at orange."""


def rgb(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue, 0 to 1, of #rrggbb."""
    red, green, blue = (int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5))
    return red, green, blue


def linear(colour: Any) -> Array:
    """Return parts of colours from 0 to 1 as amounts of light: without the gamma of screens (sRGB, IEC 61966-2-1)."""
    given = np.asarray(colour, dtype=float)
    return np.where(given <= 0.04045, given / 12.92, ((given + 0.055) / 1.055) ** 2.4)


def error_map() -> Any:
    """Return matplotlib's colour map of tip errors: from light orange for none to dark red for the largest."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps[_ERROR_MAP](np.linspace(_ERROR_START, 1.0, 256)), name="tip error")


def value_map() -> Any:
    """Return matplotlib's colour map of quantities that are no errors."""
    from matplotlib import colormaps

    return colormaps["viridis"]


def contact_map() -> Any:
    """Return matplotlib's colour map of contact forces: pale for hardly any, dark for the largest."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("contact", ["#FAD1E6", CONTACT, "#4A0030"])


def things() -> Iterator[Look]:
    """Return the looks of objects that are touched, again and again."""
    return cycle(THINGS)


def failure_map() -> Any:
    """Return matplotlib's colour map of shares that failed: white for none."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("failed", ["#FFFFFF", FAINT, TARGET])


def error_colours(error: Array, largest: float) -> Array:
    """Return colours, shape (K, 3), of tip errors [m], shape (K,), between none and the largest [m]."""
    share = np.clip(error / max(largest, 1e-12), 0, 1)
    return np.asarray(error_map()(share))[:, :3]


def error_scale(steps: int = 11) -> list[tuple[float, str]]:
    """Return shares from 0 to 1 and their colours (#rrggbb), as plotting libraries of web pages take them."""
    shares = np.linspace(0, 1, steps)
    hexes = (hex_colour(tint) for tint in error_colours(shares, 1.0))
    return list(zip(shares.tolist(), hexes, strict=True))

"""How well a colour is told from what it stands on."""

from __future__ import annotations

from contarm_sim.model.colours import hex_colour
from contarm_sim.view.colours import linear, rgb

LINES = 3.0
"""Least contrast of lines and marks (WCAG 2.2, 1.4.11); that of text is 4.5."""


def contrast(one: str, other: str) -> float:
    """Return the contrast of two colours #rrggbb, 1 to 21 (WCAG 2.2)."""
    low, high = sorted((_luminance(one), _luminance(other)))
    return (high + 0.05) / (low + 0.05)


def lightened(colour: str, paper: str, least: float = LINES) -> str:
    """Return a colour mixed with as little white as gives it a contrast with dark paper; itself where it has that."""
    for share in range(0, 101, 2):
        mixed = hex_colour(part + (1 - part) * share / 100 for part in rgb(colour))
        if contrast(mixed, paper) >= least:
            return mixed
    return "#ffffff"


def _luminance(colour: str) -> float:
    return float(linear(rgb(colour)) @ (0.2126, 0.7152, 0.0722))

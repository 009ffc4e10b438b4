"""Colours of the muscles, the same in models, films, figures and the live page."""

from __future__ import annotations

from collections.abc import Iterable

_COLOURS = (
    (0.84, 0.15, 0.16, 1.0),
    (0.17, 0.50, 0.72, 1.0),
    (0.95, 0.63, 0.10, 1.0),
    (0.10, 0.60, 0.56, 1.0),
    (0.50, 0.33, 0.22, 1.0),
    (0.88, 0.47, 0.70, 1.0),
)


def muscle_colour(index: int) -> tuple[float, float, float, float]:
    """Return red, green, blue and opacity of a muscle of a section, numbered from 0; the seventh has the first's."""
    return _COLOURS[index % len(_COLOURS)]


def muscle_hex(index: int) -> str:
    """Return the same colour as #rrggbb."""
    return hex_colour(muscle_colour(index)[:3])


def hex_colour(parts: Iterable[float]) -> str:
    """Return #rrggbb of red, green and blue, 0 to 1."""
    return "#" + "".join(f"{round(255 * part):02x}" for part in parts)

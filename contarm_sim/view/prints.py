"""What figures are written: kinds of files, widths in print, with or without headings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

from contarm_sim.errors import InputError

Kind = Literal["png", "pdf", "svg"]
Width = Literal["column", "page"]
KINDS: tuple[Kind, ...] = get_args(Kind)
WIDTHS: dict[Width, float] = {"column": 85.0, "page": 170.0}
"""Widths of figures in print [mm]."""


@dataclass(frozen=True)
class Prints:
    """What figures are written.

    Attributes:
        kinds: of files; without any, no figure is drawn.
        widths: that each figure is drawn at. Figures of the first have the plain name, those of others have the width
            in theirs: path-column.pdf.
        titles: whether a figure has a heading.

    Raises:
        InputError: an unknown kind or width, or one given twice.
    """

    kinds: tuple[Kind, ...] = ("png",)
    widths: tuple[Width, ...] = ("page",)
    titles: bool = True

    def __post_init__(self) -> None:
        _check("kinds", self.kinds, KINDS)
        _check("widths", self.widths, tuple(WIDTHS))

    def names(self, stem: str) -> dict[Width, list[str]]:
        """Return the names of the files of a figure by its widths."""
        if not self.kinds:
            return {}
        stems = {width: stem if width == self.widths[0] else f"{stem}-{width}" for width in self.widths}
        return {width: [f"{name}.{kind}" for kind in self.kinds] for width, name in stems.items()}

    def all_names(self, stem: str) -> list[str]:
        """Return the names of all files of a figure."""
        return [name for names in self.names(stem).values() for name in names]


def _check(name: str, given: Any, allowed: tuple[str, ...]) -> None:
    if not isinstance(given, tuple) or any(one not in allowed for one in given) or len(set(given)) < len(given):
        raise InputError(name, repr(given), f"a tuple of some of {', '.join(allowed)}, each once")


PLAIN = Prints()
"""One picture (.png), as wide as a page."""

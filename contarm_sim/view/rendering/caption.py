"""Rows of text along the top of a picture: numbers of one run or of two side by side, notes, what colours mean."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

INK, SOFT, PAPER = (28, 30, 34), (85, 92, 104), (250, 250, 251)

LARGEST, SMALLEST = 0.026, 0.021
"""Size of the letters, in heights of the picture: the largest with which no row is added."""

_READABLE, _TINY = 9.0, 7.0
"""Size that letters have where pictures are small, and the least that they are made to fit with [pixels]."""

_ROW, _PAD, _BETWEEN = 1.35, 0.275, 1.5
"""Distance of rows, room above and below all of them, least distance of texts in a row, in sizes of the letters."""

_MOST = 0.3
"""Most of a picture's height that rows may cover; then notes, and then the legend, are left out."""

_SWATCH, _GAP = 1.8, 0.4
"""Length of a legend's line, and its distance from the words, in sizes of the letters."""

Legend = dict[str, Any]
"""Colours, shape (K, 3), by what they mean; drawn as a line, from left to right."""


class Caption:
    """Writes into pictures of one size. Texts that do not fit in a row go on in the next.

    Args:
        width, height: size of the pictures [pixels].
        numbers: of each run the widest texts that will be written, one after the other. Runs stand side by side.
        legend: lines to explain.
        notes: a line of each run that is the same in all pictures; parts are three spaces apart.
        letters: the largest size of the letters, in heights of the picture.
    """

    def __init__(
        self, width: int, height: int, numbers: Sequence[Sequence[str]], legend: Legend, notes: Sequence[str] = (),
        letters: float = LARGEST,
    ) -> None:  # fmt: skip
        from PIL import Image, ImageDraw

        said = [[part for part in note.split("   ") if part] for note in notes]
        said = said if any(said) else []
        most = max(letters * height, _READABLE)
        least = min(max(SMALLEST / LARGEST * letters * height, _TINY), most)
        sizes = np.linspace(most, least, 6)
        for notes_left, legend_left in ((said, legend), ([], legend), ([], {})):
            rows = [_Rows(width, size, numbers, legend_left, notes_left) for size in sizes]
            chosen = next(each for each in rows if each.count == rows[-1].count)
            if chosen.height <= _MOST * height:
                break
        self._rows = chosen
        self._strip = Image.new("RGB", (width, round(chosen.height)), PAPER)
        chosen.write_lasting(ImageDraw.Draw(self._strip))

    @property
    def height(self) -> int:
        """Number of rows of pixels that are written to."""
        return int(self._strip.height)

    @property
    def size(self) -> float:
        """Size of the letters [pixels]."""
        return self._rows.size

    def write(self, image: NDArray[np.uint8], numbers: Sequence[Sequence[str]]) -> None:
        """Write the numbers of each run into the top rows of a picture, shape (height, width, 3)."""
        from PIL import ImageDraw

        strip = self._strip.copy()
        self._rows.write_numbers(ImageDraw.Draw(strip), numbers)
        rows = min(strip.height, len(image))
        image[:rows] = np.asarray(strip)[:rows]


class _Rows:
    """Where everything goes with letters of a size [pixels]."""

    def __init__(
        self, width: int, size: float, numbers: Sequence[Sequence[str]], legend: Legend, notes: list[list[str]]
    ) -> None:
        self.size, self._font = size, font(size)
        self._margin, self._runs = round(size), max(len(numbers), 1)
        self._side = width / self._runs
        room = self._side - 2 * self._margin
        self._legend, self._notes = legend, [self._broken(parts, room) for parts in notes]
        self._numbers_at = [self._flow([self._font.getlength(text) for text in texts], room) for texts in numbers]
        first = 1 + max((row for places in self._numbers_at for row, _ in places), default=0)
        self._notes_at = [
            self._flow([self._font.getlength(part) for part in parts], room, first) for parts in self._notes
        ]  # fmt: skip
        after = 1 + max((row for places in self._notes_at for row, _ in places), default=first - 1)
        widths = [(_SWATCH + _GAP) * size + self._font.getlength(name) for name in legend]
        self._legend_at = self._flow(widths, width - 2 * self._margin, after)
        self.count = after + (1 + self._legend_at[-1][0] - after if legend else 0)
        if self._runs > 1 and legend and self._legend_at[-1][0] == after:  # it is of all runs: in the middle
            left = 0.5 * (width - (self._legend_at[-1][1] + widths[-1] - self._margin)) - self._margin
            self._legend_at = [(row, x + left) for row, x in self._legend_at]
        elif self._runs == 1 and legend:
            self._join(width - self._margin, widths, numbers[0], first, after)

    @property
    def height(self) -> float:
        return self.size * (_ROW * self.count + 2 * _PAD)

    def _join(self, right: float, widths: list[float], numbers: Sequence[str], first: int, after: int) -> None:
        """Let the legend end the row of the numbers, or that of the note, if there is room for all of it in one."""
        whole = sum(widths) + _BETWEEN * self.size * (len(widths) - 1)
        lines = [(first - 1, self._numbers_at[0], numbers)]
        if self._notes_at:
            lines.append((after - 1, self._notes_at[0], self._notes[0]))
        for row, places, texts in lines:
            ends = [x + self._font.getlength(text) for (at, x), text in zip(places, texts, strict=True) if at == row]
            if max(ends, default=0.0) + 2 * _BETWEEN * self.size + whole <= right:
                start = right - whole
                self._legend_at = [(row, start + x - self._margin) for _, x in self._flow(widths, np.inf)]
                self.count = after
                return

    def _broken(self, parts: list[str], room: float) -> list[str]:
        """Return parts of a note, those that are wider than a row broken between words."""
        pieces: list[str] = []
        for part in parts:
            pieces.append("")
            for word in part.split():
                longer = f"{pieces[-1]} {word}".strip()
                if pieces[-1] and self._font.getlength(longer) > room:
                    pieces.append(word)
                else:
                    pieces[-1] = longer
        return pieces

    def _flow(self, widths: list[float], room: float, row: int = 0) -> list[tuple[int, float]]:
        """Return row and left end of things of some widths, one after the other, in rows so wide."""
        places, x = [], 0.0
        for width in widths:
            if x > 0 and x + width > room:
                row, x = row + 1, 0.0
            places.append((row, self._margin + x))
            x += width + _BETWEEN * self.size
        return places

    def write_lasting(self, draw: Any) -> None:
        """Write what is the same in all pictures: notes and the legend."""
        for number, (parts, places) in enumerate(zip(self._notes, self._notes_at, strict=True)):
            self._write(draw, number, parts, places, SOFT)
        thick = max(2, round(0.25 * self.size))
        for (name, colours), (row, x) in zip(self._legend.items(), self._legend_at, strict=True):
            share = _SWATCH * self.size / len(colours)
            for i, colour in enumerate(colours):
                ends = [(x + i * share, self._middle(row)), (x + (i + 1) * share, self._middle(row))]
                draw.line(ends, fill=tuple(round(255 * value) for value in colour[:3]), width=thick)
            words = (x + (_SWATCH + _GAP) * self.size, self._middle(row))
            draw.text(words, name, fill=INK, font=self._font, anchor="lm")

    def write_numbers(self, draw: Any, numbers: Sequence[Sequence[str]]) -> None:
        """Write the numbers of each run."""
        for number, (texts, places) in enumerate(zip(numbers, self._numbers_at, strict=True)):
            self._write(draw, number, texts, places, INK)

    def _write(self, draw: Any, run: int, texts: Sequence[str], places: Any, ink: tuple[int, int, int]) -> None:
        for text, (row, x) in zip(texts, places, strict=True):
            short = text
            while len(short) > 2 and x + self._font.getlength(short) > self._side - 0.5 * self._margin:
                short = f"{short[:-2]}…"
            draw.text((run * self._side + x, self._middle(row)), short, fill=ink, font=self._font, anchor="lm")

    def _middle(self, row: int) -> float:
        return self.size * (_PAD + _ROW * (row + 0.5))


def font(size: float) -> Any:
    """Return matplotlib's sans serif, whose digits are all equally wide: numbers do not jump about."""
    import matplotlib
    from PIL import ImageFont

    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"), size)

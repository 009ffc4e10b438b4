"""A strip of text along the top of a picture: numbers on the left, what the colours mean on the right, a note below."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_BACKGROUND, _INK, _SOFT = (250, 250, 251), (28, 30, 34), (85, 92, 104)
_SMALLEST = 7.0


class Caption:
    """Writes into pictures of one size. The letters shrink to fit; a legend that still does not fit is left out.

    Args:
        width, height: size of the pictures [pixels].
        longest: the longest text that will be written.
        legend: names of the lines to explain and their colours, each shape (K, 3) or longer, from left to right.
        note: a second line, the same in all pictures, in letters that fit; none if empty.
    """

    def __init__(self, width: int, height: int, longest: str, legend: dict[str, Any], note: str = "") -> None:
        from PIL import Image, ImageDraw

        size = max(0.026 * height, 9.0)
        gap = round(size)
        room = width - 2 * gap
        needed = _font(size).getlength(longest)
        self._font = _font(max(min(size, size * room / needed), _SMALLEST))
        self._gap = gap
        self._middle = 0.95 * size
        self._strip = Image.new("RGB", (width, round((3.2 if note else 1.9) * size)), _BACKGROUND)
        draw = ImageDraw.Draw(self._strip)
        if note:
            fit = size * min(1.0, room / _font(size).getlength(note))
            draw.text((gap, 2.3 * size), note, fill=_SOFT, font=_font(max(fit, 1.0)), anchor="lm")
        x = width - gap - sum(self._font.getlength(name) + 3.5 * gap for name in legend) + gap
        if x > 3 * gap + needed:
            for name, colours in legend.items():
                middle = self._middle
                share = 1.8 * gap / len(colours)
                for i, colour in enumerate(colours):
                    ends = [(x + i * share, middle), (x + (i + 1) * share, middle)]
                    tint = tuple(round(255 * value) for value in colour[:3])
                    draw.line(ends, fill=tint, width=max(2, round(0.25 * size)))
                draw.text((x + 2.2 * gap, middle), name, fill=_INK, font=self._font, anchor="lm")
                x += self._font.getlength(name) + 3.5 * gap

    def write(self, image: NDArray[np.uint8], text: str) -> None:
        """Write a text into the top rows of a picture, shape (height, width, 3)."""
        from PIL import ImageDraw

        strip = self._strip.copy()
        ImageDraw.Draw(strip).text((self._gap, self._middle), text, fill=_INK, font=self._font, anchor="lm")
        rows = min(strip.height, len(image))
        image[:rows] = np.asarray(strip)[:rows]


def _font(size: float) -> Any:
    """Return matplotlib's sans serif, whose digits are all equally wide: numbers do not jump about."""
    import matplotlib
    from PIL import ImageFont

    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"), size)

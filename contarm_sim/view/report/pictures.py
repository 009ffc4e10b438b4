"""Figures and films as a page holds them: inside itself, and small enough for mail."""

from __future__ import annotations

import base64
import io
import subprocess
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any

from contarm_sim.errors import EncodingError

LARGEST_VIDEO = 1_000_000
"""A larger film [bytes] is embedded in a smaller size."""

HEIGHT = 540
"""Height of that size, and of the picture that stands before a film is played [pixels]."""

_TINTS = 256
"""Different colours of an embedded figure: what the eye cannot tell from all of them, in a third of the bytes."""


def encoded(content: bytes) -> str:
    """Return bytes as the letters that a page holds them in."""
    return base64.b64encode(content).decode()


def figure(folder: Path, stem: str) -> str | None:
    """Return the address, with all its data, of a figure that a folder has as PNG or SVG, of the smaller; or None."""
    found = []
    for kind, mime in (("png", "png"), ("svg", "svg+xml")):
        file = folder / f"{stem}.{kind}"
        if file.is_file():
            content = file.read_bytes()
            found.append((_pressed(content) if kind == "png" else content, mime))
    if not found:
        return None
    content, mime = min(found, key=lambda pair: len(pair[0]))
    return f"data:image/{mime};base64,{encoded(content)}"


def unshown(folder: Path, stems: Iterable[str]) -> str:
    """Return in a sentence which figures the page of a folder does not show, and why; "" where it shows all."""
    without = [stem for stem in stems if figure(folder, stem) is None]
    files = [f"{stem}.pdf" for stem in without if (folder / f"{stem}.pdf").is_file()]
    missing = [stem.replace("_", " ") for stem in without if f"{stem}.pdf" not in files]
    said = []
    if files:
        be = "is a figure" if len(files) == 1 else "are figures"
        said.append(f"{_listed(files)} in this folder {be} that no page can show; `--figures pdf,png` has both.")
    if missing:
        one = len(missing) == 1
        which = f"The figure {missing[0]} was" if one else f"The figures {_listed(missing)} were"
        said.append(f"{which} not drawn; `--figures png` draws {'it' if one else 'them'}.")
    return " ".join(said)


def _listed(words: list[str]) -> str:
    return " and ".join(part for part in (", ".join(words[:-1]), words[-1]) if part)


@lru_cache(maxsize=8)  # a page is written without its film first, then with it
def _pressed(content: bytes) -> bytes:
    """Return a PNG in fewer colours."""
    from PIL import Image

    pressed = io.BytesIO()
    Image.open(io.BytesIO(content)).convert("RGB").quantize(_TINTS, dither=Image.Dither.NONE).save(pressed, "PNG")
    return min(content, pressed.getvalue(), key=len)


def embedded(film: Path, seconds: float, moment: float) -> dict[str, Any]:
    """Return a film of some seconds, smaller if it is large, and the picture of a moment [s] to show before it plays.

    Raises:
        EncodingError: there is no encoder, or it failed.
    """
    from PIL import Image

    content, poster = film.read_bytes(), still(film, moment)
    if len(content) > LARGEST_VIDEO:
        from contarm_sim.view.rendering.encode import shrunk

        content = shrunk(film, HEIGHT, LARGEST_VIDEO / seconds)
    width, height = Image.open(io.BytesIO(poster)).size
    return {"data": encoded(content), "poster": encoded(poster), "width": width, "height": height}


def still(film: Path, moment: float) -> bytes:
    """Return the picture of a film at a moment [s] as JPEG.

    Raises:
        EncodingError: there is no encoder, or it failed.
    """
    from contarm_sim.view.rendering.encode import encoder

    options = ["-vf", f"scale=-2:{HEIGHT}", "-q:v", "4", "-c:v", "mjpeg", "-f", "image2pipe", "-"]
    at, at_the_end = ["-ss", f"{max(moment - 0.001, 0.0):.3f}"], ["-sseof", "-0.5"]
    for place, count in ((at, ["-frames:v", "1"]), (at_the_end, list[str]())):
        command = [encoder(), "-v", "error", *place, "-i", str(film), *count, *options]
        done = subprocess.run(command, capture_output=True)
        if done.returncode == 0 and done.stdout:
            return done.stdout[done.stdout.rindex(b"\xff\xd8\xff") :]  # the last picture
    said = done.stderr.decode(errors="replace").strip().splitlines() or ["no picture at that moment"]
    raise EncodingError(f"the video encoder failed: {said[-1]}")

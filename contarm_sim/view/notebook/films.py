"""A film of a trajectory that notebooks play, and that can be written to a file."""

from __future__ import annotations

import base64
import math
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.files import appearing
from contarm_sim.inputs import as_path, quoted
from contarm_sim.model.parameters import as_number
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.notebook.places import check_progress, check_switches, check_writable, not_written, told
from contarm_sim.view.rendering import BROADEST
from contarm_sim.view.rendering.encode import CODECS, shrunk
from contarm_sim.view.rendering.film import Progress
from contarm_sim.view.rendering.formats import SIZES, SMALL, USUAL, usual_fps
from contarm_sim.view.rendering.look import Look
from contarm_sim.view.rendering.video import WRITERS, Filmed, Shot

LARGEST = 2_500_000
"""Most bytes of a film that a notebook is given: it keeps them, in text half as long again."""

MOST_FRAMES = 10_000
"""Most frames of a film: six minutes at 30 a second take an hour to draw."""

SMALLEST = 96
"""Shortest side of a film with words or plots [pixels]."""

_FAST = 60.0  # frames per second that no screen needs more than
_CLEAR = (*(suffix for suffix, codec in CODECS.items() if codec.clear is not None), ".webp")
"""Endings of films whose edges may be transparent."""

_SMALL = 360
"""Height of a film that was made smaller to fit [pixels]."""

_KINDS = {".mp4": "video/mp4", ".webm": "video/webm", ".gif": "image/gif", ".webp": "image/webp"}
"""What browsers show, by the endings of names; a .mov is for editors."""


@dataclass(frozen=True, repr=False, eq=False)
class Film:
    """A film; notebooks play it.

    Attributes:
        content: the bytes of the file.
        suffix: what the name of its file ends in: .mp4, .mov, .webm, .gif or .webp.
        size: width and height [pixels].
        seconds: its duration [s].
        path: the file that it was written to, or None.
        shown: what notebooks are given, a kind of file and its bytes: the film, or a smaller .mp4 of a large one or of
            a .mov; None where that is too large.
    """

    content: bytes
    suffix: str
    size: tuple[int, int]
    seconds: float
    path: Path | None
    shown: tuple[str, bytes] | None

    def save(self, path: str | Path) -> None:
        """Write the film to a file, in place of what is there.

        Raises:
            InputError: a name with another ending, or a place that cannot be written to.
        """
        target = target_of(path, (self.suffix,))
        try:
            with appearing(target) as scratch:
                scratch.write_bytes(self.content)
        except OSError as error:
            raise not_written(target, error) from error

    def __repr__(self) -> str:
        where = "" if self.path is None else f", {self.path}"
        width, height = self.size
        return f"Film({width} x {height}, {self.seconds:.3g} s, {len(self.content) / 1e3:.0f} kB{where})"

    def _repr_html_(self) -> str:
        if self.shown is None:
            return f"<p>{escape(repr(self))} is too large to be shown here.</p>"
        kind, content = self.shown
        data = f"data:{kind};base64,{base64.b64encode(content).decode()}"
        words = "Film of the simulated arm"
        style = f"max-width:100%;width:{min(self.size[0], 960)}px;height:auto;border-radius:4px"
        if kind.startswith("image"):
            return f'<img alt="{words}" style="{style}" src="{data}">'
        playing = f'controls muted loop autoplay playsinline aria-label="{words}"'
        return f'<video {playing} style="{style}" src="{data}"></video>'


def film(
    samples: Trajectory, path: str | Path | None = None, *, camera: str = "front", size: Any = None,
    fps: float | None = None, speed: float = 1.0, plots: bool = True, captions: bool = True, plain: bool = False,
    transparent: bool = False, on_frame: Progress | None = None,
) -> Film:  # fmt: skip
    """Film a trajectory, see `Trajectory.film`."""
    check_switches(plots=plots, captions=captions, plain=plain, transparent=transparent)
    check_progress(on_frame)
    target = None if path is None else target_of(path, tuple(WRITERS))
    suffix = ".mp4" if target is None else target.suffix.lower()
    if transparent and suffix not in _CLEAR:
        given = "True for a film without a file, a .mp4" if target is None else f"True for a {suffix}"
        raise InputError("transparent", given, f"a path that ends in {' or '.join(_CLEAR)}")
    width, height = size_of(size, SMALL if target is None else SIZES[USUAL])
    rate = fps if fps is not None else usual_fps(suffix, samples.moving, small=target is None)
    _refuse_too_long(samples, rate, speed)
    look = Look(width, height, camera, plots=plots, captions=captions, transparent=transparent)
    look = look.plain() if plain else look
    shot = Shot(samples, look, rate, speed).checked()
    if (look.captions or look.plots) and not transparent and min(width, height) < SMALLEST:
        raise InputError("size", (width, height), f"at least {SMALLEST} pixels a side; plain=True is for smaller ones")
    if target is not None:
        check_writable(target)
    return filmed(shot, suffix, (width, height), shot.count / rate, target, on_frame)


def filmed(
    shot: Filmed, suffix: str, size: tuple[int, int], seconds: float, target: Path | None, on_frame: Progress | None
) -> Film:
    """Make a film, and write it to a file if there is one.

    Args:
        shot: its frames.
        suffix: what it is written as, such as .mp4.
        size: of a frame [pixels].
        seconds: that it takes.
        target: the file, or None.
        on_frame: called with each frame.

    Raises:
        InputError: the file cannot be written to.
    """
    with TemporaryDirectory() as folder:
        made = Path(folder) / f"film{suffix}"
        WRITERS[suffix](shot, made, told(on_frame))
        if target is not None:
            try:
                with appearing(target) as scratch:
                    shutil.copyfile(made, scratch)
            except OSError as error:
                raise not_written(target, error) from error
        return Film(made.read_bytes(), suffix, size, seconds, target, shown_of(made, size[1], seconds))


def shown_of(film: Path, height: int, seconds: float) -> tuple[str, bytes] | None:
    """Return the kind and the bytes of what a notebook is given of a film."""
    kind = _KINDS.get(film.suffix)
    if kind is not None and film.stat().st_size <= LARGEST:
        return kind, film.read_bytes()
    if film.suffix not in CODECS:
        return None
    small = shrunk(film, min(_SMALL, height), 0.8 * LARGEST / seconds)  # a start takes more than its share
    return (_KINDS[".mp4"], small) if len(small) <= LARGEST else None


def _refuse_too_long(samples: Trajectory, fps: Any, speed: Any) -> None:
    """Refuse a film of more frames than anybody waits for.

    Raises:
        InputError: says how many; also for a rate or speed that is no positive number.
    """
    for name, value in (("fps", fps), ("speed", speed)):
        if not 0 < as_number(value) < math.inf:
            raise InputError(name, value, "a positive number")
    frames = (samples.time[-1] - samples.time[0]) * fps / speed if len(samples) else 0.0
    if frames > MOST_FRAMES:
        name, value = ("fps", fps) if fps > _FAST else ("speed", speed)
        raise InputError(name, f"{value:g}, which makes {frames:.0f} frames", f"at most {MOST_FRAMES:,} frames")


def size_of(given: Any, usual: tuple[int, int]) -> tuple[int, int]:
    """Return a film's width and height [pixels], the usual ones unless given.

    Raises:
        InputError: not two numbers, or too large ones.
    """
    if given is None:
        return usual
    if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 2:
        raise InputError("size", given, "width and height [pixels], such as (1280, 720)")
    if any(isinstance(side, int) and side > BROADEST for side in given):
        raise InputError("size", tuple(given), f"at most {BROADEST} pixels a side")
    return given[0], given[1]


def target_of(path: str | Path, suffixes: tuple[str, ...]) -> Path:
    """Return a file that can be written to.

    Raises:
        InputError: a name with another ending, or a folder that is not there.
    """
    allowed = f"a name that ends in {' or '.join(suffixes)}"
    target = as_path("path", path, allowed)
    if target.suffix.lower() not in suffixes:
        raise InputError("path", quoted(target), allowed)
    try:
        there = target.parent.is_dir() and not target.is_dir()
    except OSError:  # a name too long
        there = False
    if not there:
        raise InputError("path", quoted(target), "a file in an existing folder")
    return target

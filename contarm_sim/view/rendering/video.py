"""A simulation as a film (H.264, ProRes, VP9, GIF or WebP), as a folder of pictures, or one picture of it."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing
from dataclasses import dataclass
from itertools import accumulate, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.files import appearing
from contarm_sim.view.rendering.draw import Pixels
from contarm_sim.view.rendering.encode import CODECS, encoder, encoding
from contarm_sim.view.rendering.film import Progress, film, film_beside
from contarm_sim.view.rendering.formats import FPS, check_size
from contarm_sim.view.rendering.look import Look, frame_indices

if TYPE_CHECKING:
    from contarm_sim.results.trajectory import Trajectory

_PALETTE_FRAMES = 8

_QUICK = 3
"""How hard pictures of a sequence are pressed, of 9."""


class Filmed(Protocol):
    """What a moving picture is written of; see `Shot`, which is one."""

    @property
    def look(self) -> Look:
        """Size [pixels], and whether edges are transparent."""
        ...

    @property
    def fps(self) -> float:
        """Frames per second."""
        ...

    @property
    def count(self) -> int:
        """Number of frames."""
        ...

    def frames(self, on_frame: Progress | None = None, some: int | None = None) -> Generator[Pixels, None, None]:
        """Draw all frames one after the other, or `some` of them, evenly picked."""
        ...

    def checked(self) -> Filmed:
        """Return itself, or raise an InputError."""
        ...


@dataclass(frozen=True)
class Shot:
    """What a moving picture shows.

    Attributes:
        samples: a run.
        beside: another run to show on the right of it.
        names: of the two, for their captions.
        notes: what is said of each whole run where there are two; of one, `look.note`.
        fps: frames per second; each shows the sample nearest to its time.
        speed: simulated over shown time.
        look: size [pixels], camera, plots.
    """

    samples: Trajectory
    look: Look
    fps: float = FPS
    speed: float = 1.0
    beside: Trajectory | None = None
    names: tuple[str, str] = ("", "")
    notes: tuple[str, str] = ("", "")

    def frames(self, on_frame: Progress | None = None, some: int | None = None) -> Generator[Pixels, None, None]:
        """Draw all frames one after the other, or `some` of them, evenly picked."""
        step = 1 if some is None else -(-self.count // some)
        one, *others = ((run, indices[::step]) for run, indices in self._indices())
        if not others:
            return film(*one, self.look, on_frame, None, self.speed)
        return film_beside(one, others[0], self.look, on_frame, self.names, self.notes, self.speed)

    @property
    def count(self) -> int:
        """Number of frames; of two runs that of the longer one."""
        return max(len(indices) for _, indices in self._indices())

    def _indices(self) -> list[tuple[Trajectory, list[int]]]:
        """Return each run with the samples that frames show."""
        runs = (self.samples,) if self.beside is None else (self.samples, self.beside)
        return [(run, frame_indices(run, self.fps, self.speed)) for run in runs]

    def checked(self) -> Shot:
        """Return itself.

        Raises:
            InputError: a size, rate or speed that cannot be used.
        """
        check_size(self.look.width, self.look.height)
        self._indices()
        return self


def write_video(shot: Filmed, path: Path, on_frame: Progress | None = None) -> None:
    """Write a video: .mp4 (H.264), .mov (ProRes 4444) or .webm (VP9); the file appears when it is complete.

    Args:
        path: the file, in an existing folder.
        on_frame: called with the number of frames written and their total, for progress.

    Raises:
        InputError: a value that cannot be used.
        RenderingError: no GL library draws here, or there is no working encoder.
    """
    path = _checked(path, *CODECS)
    look, codec = shot.checked().look, CODECS[path.suffix]
    if look.transparent and codec.clear is None:
        clear = ", ".join(suffix for suffix, each in CODECS.items() if each.clear)
        raise InputError("path", path, f"a kind of file that may be transparent: {clear}, .webp or pictures")
    for name, value in (("width", look.width), ("height", look.height)):
        if value % 2:
            raise InputError(name, value, "an even number [pixels]: videos halve the colours' resolution")
    program = encoder(codec.name)
    with (
        appearing(path) as temporary,
        closing(shot.frames(on_frame)) as images,
        encoding(program, temporary, (look.height, look.width), shot.fps, look.transparent) as add,
    ):
        for image in images:
            add(image)


def write_pictures(shot: Filmed, folder: Path, on_frame: Progress | None = None) -> None:
    """Write every frame as frame-00001.png and so on into a folder that is there; arguments as `write_video`.

    Raises:
        InputError: a value that cannot be used.
        RenderingError: no GL library draws here.
    """
    from PIL import Image

    with closing(shot.checked().frames(on_frame)) as images:
        for number, image in enumerate(images, 1):
            Image.fromarray(image).save(folder / f"frame-{number:05d}.png", compress_level=_QUICK)


def write_gif(shot: Filmed, path: Path, on_frame: Progress | None = None) -> None:
    """Write an animated picture (.gif) with one palette for all frames; arguments as `write_video`.

    Raises:
        InputError: a value that cannot be used.
        RenderingError: no GL library draws here.
    """
    from PIL import Image

    path = _checked(path, ".gif")
    if shot.look.transparent:
        raise InputError("path", path, "a kind of file whose edges may be transparent: .mov, .webm, .webp or pictures")
    if shot.fps > 50:
        raise InputError("fps", shot.fps, "1 to 50 in a GIF: browsers slow faster ones down")
    count = shot.checked().count
    typical = Image.fromarray(np.vstack(list(shot.frames(some=_PALETTE_FRAMES))))
    palette = typical.quantize(255, Image.Quantize.MEDIANCUT, kmeans=2)
    ends = accumulate([100 / shot.fps] * count, initial=0.0)  # a GIF counts hundredths of a second
    durations = [10 * (round(end) - round(start)) for start, end in pairwise(ends)]
    with appearing(path) as temporary, closing(shot.frames(on_frame)) as images:
        frames = (Image.fromarray(image).quantize(palette=palette, dither=Image.Dither.NONE) for image in images)
        with temporary.open("wb") as file:
            next(frames).save(file, "GIF", save_all=True, append_images=frames, duration=durations, loop=0)


def write_webp(shot: Filmed, path: Path, on_frame: Progress | None = None) -> None:
    """Write an animated picture (.webp), smaller than a GIF and in full colour; arguments as `write_video`.

    Raises:
        InputError: a value that cannot be used.
        RenderingError: no GL library draws here.
    """
    from PIL import Image

    path = _checked(path, ".webp")
    with appearing(path) as temporary, closing(shot.checked().frames(on_frame)) as images:
        frames = (Image.fromarray(image) for image in images)
        with temporary.open("wb") as file:
            next(frames).save(
                file, "WEBP", save_all=True, append_images=frames, duration=round(1000 / shot.fps), loop=0, quality=75
            )


def write_still(shot: Shot, path: Path, time: float) -> None:
    """Write the picture (.png) of the sample nearest to a time [s].

    Raises:
        InputError: a value that cannot be used, or a time outside the run.
        RenderingError: no GL library draws here.
    """
    from PIL import Image

    path, samples = _checked(path, ".png"), shot.checked().samples
    if not samples.time[0] <= time <= samples.time[-1]:
        raise InputError("time", time, f"{samples.time[0]:g} to {samples.time[-1]:g} s")
    one, *beside = ((each, [int(np.abs(each.time - time).argmin())]) for each in (samples, shot.beside) if each)
    images = film_beside(one, beside[0], shot.look, None, shot.names, shot.notes) if beside else film(*one, shot.look)
    with appearing(path) as temporary, closing(images):
        Image.fromarray(next(images)).save(temporary, "PNG", optimize=True)


WRITERS = {**dict.fromkeys(CODECS, write_video), ".gif": write_gif, ".webp": write_webp}
"""What writes a moving picture, by the ending of its name."""


def _checked(path: Path, *suffixes: str) -> Path:
    """Refuse a file that cannot be written.

    Raises:
        InputError: the name does not end as it must, or the folder does not exist.
    """
    path = Path(path)
    if path.suffix not in suffixes:
        raise InputError("path", path, f"a name that ends in {' or '.join(suffixes)}")
    if not path.parent.is_dir():
        raise InputError("path", path, "a file in an existing folder")
    return path

"""A simulation as a film: H.264 in MP4, or an animated GIF."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from itertools import accumulate, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.errors import InputError, RenderingError
from contarm_sim.rendering.draw import Pixels, Quality, check_size
from contarm_sim.rendering.film import Look, Progress, appearing, film, frame_indices

if TYPE_CHECKING:
    from contarm_sim.simulation.samples import Samples

_PALETTE_FRAMES = 8


def write_video(
    arm: Arm,
    samples: Samples,
    path: Path,
    fps: float = 30,
    width: int = 1280,
    height: int = 720,
    speed: float = 1.0,
    camera: str = "front",
    quality: Quality = "draft",
    on_frame: Progress | None = None,
) -> None:
    """Write the samples as a video (.mp4); the file appears when it is complete.

    Args:
        path: the file, in an existing folder.
        fps: frames per second; each shows the sample nearest to its time.
        width, height: size [pixels], even numbers.
        speed: simulated over shown time.
        camera: a camera of the scene: front, side or top.
        quality: `draft` for speed, `final` for smooth edges.
        on_frame: called with the number of frames written and their total, for progress.

    Raises:
        InputError: a value that cannot be used.
        RenderingError: no GL library draws here, or there is no working encoder.
    """
    path = _checked(path, ".mp4")
    check_size(width, height)
    for name, value in (("width", width), ("height", height)):
        if value % 2:
            raise InputError(name, value, "an even number [pixels]: H.264 halves the colours' resolution")
    indices = frame_indices(samples, fps, speed)
    program = encoder()
    with appearing(path) as temporary:
        images = film(arm, samples, indices, Look(width, height, camera, quality), on_frame)
        with closing(images), _encoding(program, temporary, (height, width), fps) as add:
            for image in images:
                add(image)


def write_gif(
    arm: Arm,
    samples: Samples,
    path: Path,
    fps: float = 15,
    width: int = 480,
    height: int = 270,
    speed: float = 1.0,
    camera: str = "front",
    quality: Quality = "final",
    on_frame: Progress | None = None,
) -> None:
    """Write the samples as an animated picture (.gif) with one palette for all frames; arguments as `write_video`.

    Raises:
        InputError: a value that cannot be used.
        RenderingError: no GL library draws here.
    """
    from PIL import Image

    path = _checked(path, ".gif")
    indices = frame_indices(samples, fps, speed)
    look = Look(width, height, camera, quality)
    some = indices[:: -(-len(indices) // _PALETTE_FRAMES)]
    typical = Image.fromarray(np.vstack(list(film(arm, samples, some, look))))
    palette = typical.quantize(255, Image.Quantize.MEDIANCUT, kmeans=2)
    ends = accumulate([100 / fps] * len(indices), initial=0.0)  # a GIF counts hundredths of a second
    durations = [10 * (round(end) - round(start)) for start, end in pairwise(ends)]
    with appearing(path) as temporary, closing(film(arm, samples, indices, look, on_frame)) as images:
        frames = (Image.fromarray(image).quantize(palette=palette, dither=Image.Dither.NONE) for image in images)
        with temporary.open("wb") as file:
            next(frames).save(file, "GIF", save_all=True, append_images=frames, duration=durations, loop=0)


def encoder() -> str:
    """Return the ffmpeg to use: the one on PATH, or the one that comes with imageio-ffmpeg.

    Raises:
        RenderingError: there is neither.
    """
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        raise RenderingError("no video encoder: install ffmpeg or the Python package imageio-ffmpeg") from None


@contextmanager
def _encoding(program: str, path: Path, shape: tuple[int, int], fps: float) -> Iterator[Callable[[Pixels], None]]:
    """Yield a function that hands one frame to the encoder, and end the encoder whatever happens.

    Raises:
        RenderingError: the encoder failed; says why.
    """
    import mediapy

    mediapy.set_ffmpeg(program)
    options = ["-preset", "veryfast", "-movflags", "+faststart"]
    writer = mediapy.VideoWriter(
        path, shape, fps=fps, codec="h264", crf=20, encoded_format="yuv420p", ffmpeg_args=options
    )

    def add(image: Pixels) -> None:
        with _speaking(writer):
            writer.add_image(image)

    try:
        with _speaking(writer):
            writer.__enter__()
        yield add
        with _speaking(writer):
            writer.close()
    except BaseException:
        with suppress(Exception):  # Ctrl-C in a terminal stops the encoder too
            writer.close()
        raise


@contextmanager
def _speaking(writer: Any) -> Iterator[None]:
    """Turn a failure of the encoder into an error that repeats the encoder's last words."""
    try:
        yield
    except (OSError, RuntimeError) as error:
        said: Exception | None = error
        while isinstance(said, OSError):  # a broken pipe says nothing; closing it again brings the reason
            said = _closing(writer)
        lines = [line.strip() for line in str(said or error).splitlines() if line.strip()]
        raise RenderingError(f"the video encoder failed: {lines[-1] if lines else type(error).__name__}") from error


def _closing(writer: Any) -> Exception | None:
    """Close a writer; return what that raises."""
    try:
        writer.close()
    except (OSError, RuntimeError) as error:
        return error
    return None


def _checked(path: Path, suffix: str) -> Path:
    """Refuse a file name of another kind.

    Raises:
        InputError: the name does not end as it must.
    """
    path = Path(path)
    if path.suffix != suffix:
        raise InputError("path", path, f"a name that ends in {suffix}")
    return path

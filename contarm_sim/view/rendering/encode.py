"""Frames to H.264: which encoder there is, and a pipe to it that says why it failed."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from contarm_sim.errors import EncodingError
from contarm_sim.view.rendering.draw import Pixels

_REPRODUCIBLE = ["-threads", "1", "-fflags", "+bitexact", "-flags:v", "+bitexact"]
"""What x264 writes depends on its number of threads, which is that of the processors unless given."""

_SLOWEST = 12_500
"""Rate below which a picture is not pressed [bytes/s]."""


def encoder() -> str:
    """Return the ffmpeg to use: the one on PATH, or the one that comes with imageio-ffmpeg.

    Raises:
        EncodingError: there is neither.
    """
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        raise EncodingError("no video encoder: install ffmpeg or the Python package imageio-ffmpeg") from None


def shrunk(film: Path, height: int, rate: float) -> bytes:
    """Return a video of a smaller height [pixels] made from another, at most at a rate [bytes/s] on average.

    Raises:
        EncodingError: there is no encoder, or it failed.
    """
    with TemporaryDirectory() as folder:
        small = Path(folder) / "small.mp4"
        bits = round(8 * max(rate, _SLOWEST))
        options = ["-vf", f"scale=-2:{height}", "-c:v", "libx264", "-crf", "24", "-preset", "veryfast", "-an"]
        options += ["-maxrate", str(bits), "-bufsize", str(2 * bits), "-movflags", "+faststart", *_REPRODUCIBLE]
        command = [encoder(), "-v", "error", "-i", str(film), *options, str(small)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise EncodingError(f"the video encoder failed: {(done.stderr.strip().splitlines() or ['?'])[-1]}")
        return small.read_bytes()


@contextmanager
def encoding(program: str, path: Path, shape: tuple[int, int], fps: float) -> Iterator[Callable[[Pixels], None]]:
    """Yield a function that hands one frame to the encoder, and end the encoder whatever happens.

    Raises:
        EncodingError: the encoder failed; says why.
    """
    import mediapy

    mediapy.set_ffmpeg(program)
    options = ["-preset", "veryfast", "-movflags", "+faststart", *_REPRODUCIBLE]
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
        raise EncodingError(f"the video encoder failed: {lines[-1] if lines else type(error).__name__}") from error


def _closing(writer: Any) -> Exception | None:
    """Close a writer; return what that raises."""
    try:
        writer.close()
    except (OSError, RuntimeError) as error:
        return error
    return None

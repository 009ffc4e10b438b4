"""Frames to a video: which encoder there is, and a pipe to it that says why it failed."""

from __future__ import annotations

import functools
import re
import shutil
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread

import numpy as np

from contarm_sim.errors import EncodingError, one_line
from contarm_sim.stopping import unbroken
from contarm_sim.view.rendering.draw import Pixels

_REPRODUCIBLE = ("-threads", "1", "-fflags", "+bitexact", "-flags:v", "+bitexact")
"""What x264 writes depends on its number of threads, which is that of the processors unless given."""

_COLOURS = (
    "-vf", "scale=out_color_matrix=bt709:out_range=tv", "-colorspace", "bt709", "-color_primaries", "bt709",
    "-color_trc", "bt709", "-color_range", "tv",
)  # fmt: skip
"""Said in the file, for players guess by the size otherwise, and show other colours than were drawn."""

_SLOWEST = 12_500
"""Rate below which a picture is not pressed [bytes/s]."""


@dataclass(frozen=True)
class Codec:
    """How a kind of file is encoded.

    Attributes:
        name: of ffmpeg's encoder.
        options: its own.
        pixels, clear: formats of pixels without and with opacity; None: it has none.
    """

    name: str
    options: tuple[str, ...]
    pixels: str
    clear: str | None = None


CODECS = {
    ".mp4": Codec("libx264", ("-crf", "20", "-preset", "veryfast", "-movflags", "+faststart"), "yuv420p"),
    ".mov": Codec("prores_ks", ("-profile:v", "4444", "-vendor", "apl0"), "yuv444p10le", "yuva444p10le"),
    ".webm": Codec(
        "libvpx-vp9",
        ("-crf", "24", "-b:v", "0", "-deadline", "good", "-cpu-used", "5", "-auto-alt-ref", "0"),
        "yuv420p", "yuva420p",
    ),
}  # fmt: skip
"""H.264, ProRes 4444 and VP9, by the ending of a file's name."""


def encoder(codec: str = CODECS[".mp4"].name) -> str:
    """Return the ffmpeg to use: the one on PATH, or the one of imageio-ffmpeg where that has not got the codec.

    Raises:
        EncodingError: neither has.
    """
    programs = [found] if (found := shutil.which("ffmpeg")) is not None else []
    with suppress(ImportError, RuntimeError):
        import imageio_ffmpeg

        programs.append(str(imageio_ffmpeg.get_ffmpeg_exe()))
    if not programs:
        raise EncodingError("no video encoder: install ffmpeg or the Python package imageio-ffmpeg")
    for program in programs:
        if codec in _codecs(program):
            return program
    raise EncodingError(
        f"no video encoder with {codec}: not {' and not '.join(programs)}; install an ffmpeg built with it"
    )


@functools.lru_cache
def _codecs(program: str) -> frozenset[str]:
    """Return the names of the encoders that an ffmpeg has; none where it does not run."""
    try:
        done = subprocess.run([program, "-hide_banner", "-encoders"], capture_output=True, text=True)
    except OSError:
        return frozenset()
    return frozenset(words[1] for line in done.stdout.splitlines() if len(words := line.split()) > 1)


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
            raise EncodingError(_reason(done.stderr, done.returncode))
        return small.read_bytes()


@contextmanager
def encoding(
    program: str, path: Path, shape: tuple[int, int], fps: float, transparent: bool = False
) -> Iterator[Callable[[Pixels], None]]:
    """Yield a function that hands one frame to the encoder, and end the encoder whatever happens.

    The encoder works beside whoever draws the next frame: it is a process of its own behind a pipe.

    Args:
        path: the file; its ending says how it is encoded.
        shape: height and width [pixels].
        transparent: frames have opacity, shape (height, width, 4).

    Raises:
        EncodingError: the encoder failed; says why.
    """
    codec = CODECS[path.suffix]
    source = ["-f", "rawvideo", "-pix_fmt", "rgba" if transparent else "rgb24", "-s", f"{shape[1]}x{shape[0]}"]
    kind = codec.clear if transparent and codec.clear else codec.pixels
    command = [
        program, "-v", "error", "-y", *source, "-framerate", str(fps), "-i", "-", "-an", "-c:v", codec.name,
        *codec.options, "-pix_fmt", kind, *_COLOURS, *_REPRODUCIBLE, str(path),
    ]  # fmt: skip
    pipe, said = subprocess.PIPE, bytearray()
    # A session of its own: Ctrl-C in a terminal is for us, who then end the encoder.
    with ExitStack() as ended:
        with unbroken():  # or an interruption while it starts would leave it to write on by itself
            process = ended.enter_context(
                subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.STDOUT, start_new_session=True)
            )
            ended.callback(process.kill)
        stdin, stdout = process.stdin, process.stdout
        assert stdin is not None
        assert stdout is not None
        reader = Thread(target=lambda: said.extend(stdout.read()), daemon=True)
        reader.start()

        def finish() -> None:
            with suppress(OSError):
                stdin.close()
            process.wait()
            reader.join()

        def add(image: Pixels) -> None:
            try:
                stdin.write(np.ascontiguousarray(image).data)
            except OSError as error:  # a broken pipe says nothing
                finish()
                raise EncodingError(_reason(said.decode(errors="replace"), process.returncode)) from error

        try:
            yield add
            finish()
            if process.returncode:
                raise EncodingError(_reason(said.decode(errors="replace"), process.returncode))
        except BaseException:
            process.kill()
            finish()
            raise


def _reason(said: str, code: int) -> str:
    """Return the encoder's last words, or how it ended."""
    lines = [line.strip() for line in said.splitlines() if line.strip() and "Conversion failed" not in line]
    words = [one_line(re.sub(r"^(\[[^]]*\] *)+", "", lines[-1]))] if lines else []  # without who said it
    if code < 0:
        words.append(f"ended by {signal.Signals(-code).name}")
    return f"the video encoder failed: {', '.join(words) or f'exit code {code}'}"

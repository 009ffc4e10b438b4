"""Films, read again."""

import subprocess

import numpy as np

from contarm_sim.view.rendering.encode import encoder


def decoded(film, size):
    """Return the frames of a film, shape (frames, height, width, 3), as int16, and what the decoder says of it."""
    words = [encoder(), "-i", str(film), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(words, capture_output=True, check=True)
    return np.frombuffer(done.stdout, np.uint8).reshape(-1, *size, 3).astype(np.int16), done.stderr.decode()

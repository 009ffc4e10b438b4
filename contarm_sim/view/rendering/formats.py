"""Sizes and frame rates of films: by name, unless given, and such as can be."""

from __future__ import annotations

from contarm_sim.errors import InputError

SIZES = {"480p": (854, 480), "720p": (1280, 720), "1080p": (1920, 1080), "2160p": (3840, 2160)}
"""Width and height [pixels], by name."""

USUAL = "720p"
SMALL = (640, 360)
"""Sizes unless given: of files, and of what a page or a notebook holds."""

FPS = 30.0
_SLOW = {".gif": 15.0, ".webp": 15.0}
_SMALL = {".mp4": 20.0, ".gif": 10.0}
_POSES = 2.0
"""Frames per second unless given: of films, of animated pictures, of small ones, and of poses at rest."""


def usual_fps(suffix: str, moving: bool, small: bool = False) -> float:
    """Return the frames per second of a kind of file (.mp4) unless given; poses at rest are a frame each."""
    if not moving:
        return _POSES
    return _SMALL[suffix] if small else _SLOW.get(suffix, FPS)


def check_size(width: int, height: int) -> None:
    """Refuse sizes that are no positive whole numbers.

    Raises:
        InputError: names the side.
    """
    for name, value in (("width", width), ("height", height)):
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise InputError(name, value, "a positive whole number [pixels]")

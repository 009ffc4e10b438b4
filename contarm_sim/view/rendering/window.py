"""A window of MuJoCo's own viewer, where there is a display."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from contarm_sim.errors import RenderingError


def has_display() -> bool:
    """Tell whether there is anything to open a window on."""
    named = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return bool(named) or not sys.platform.startswith("linux")


@contextmanager
def window(model: Any, data: Any, on_key: Callable[[int], object] | None = None) -> Iterator[Any]:
    """Open a window that shows what `data` holds whenever it is synced; closed and gone when left.

    Args:
        on_key: called with GLFW's number of each key pressed, in another thread.

    Raises:
        RenderingError: there is no display, or no window can be opened on it.
    """
    if not has_display():
        raise RenderingError("no window: there is no display here (DISPLAY is not set)")
    import mujoco.viewer

    before = set(threading.enumerate())
    try:
        opened = mujoco.viewer.launch_passive(model, data, key_callback=on_key, show_left_ui=False, show_right_ui=False)
    except Exception as error:  # the window system's own, of any kind
        raise RenderingError(f"no window: {error}") from error
    try:
        yield opened
    finally:
        opened.close()
        for thread in set(threading.enumerate()) - before:  # still drawing when Python ends, it would crash
            thread.join(5.0)

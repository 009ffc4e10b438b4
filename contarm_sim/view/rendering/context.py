"""MuJoCo's renderer, given back in time and in its place.

MuJoCo and dm_control end EGL when Python ends, each without asking who else draws, and what is still open then prints
a page of traces. And MuJoCo frees what a renderer holds in whichever context was used last, which spoils the pictures
of another renderer that is still open.
"""

from __future__ import annotations

import atexit
import functools
import sys
import threading
import weakref
from contextlib import suppress
from typing import Any

from contarm_sim.errors import MESSAGE, RenderingError, one_line
from contarm_sim.view.rendering.gl import choose_backend

_open: weakref.WeakSet[Any] = weakref.WeakSet()


def open_renderer(model: Any, width: int, height: int) -> Any:
    """Return a `mujoco.Renderer` for pictures of a size [pixels]; close it, or leave it to the end of Python.

    Raises:
        RenderingError: no GL library draws here, or none so large a picture.
    """
    choose_backend()
    import mujoco

    try:
        renderer = _kind()(model, height, width)
    except mujoco.FatalError as error:
        raise RenderingError(f"no picture of {width} x {height} pixels: {str(error).splitlines()[0]}") from error
    _open.add(renderer)
    keep_egl()
    return renderer


def keep_egl() -> None:
    """Leave EGL to the end of the process, and what is open to the end of Python; call after loading a GL library."""
    for name in ("mujoco.egl", "dm_control._render.pyopengl.egl_renderer"):
        if name in sys.modules:
            atexit.unregister(sys.modules[name].EGL.eglTerminate)
    atexit.unregister(_close_all)
    atexit.register(_close_all)


def _close_all() -> None:
    for renderer in list(_open):
        renderer.close()


def _tell_dm_control() -> None:
    """Make dm_control set its own context before it draws again; it believes that nobody else sets any."""
    base = sys.modules.get("dm_control._render.base")
    if base is not None:
        place = base._CURRENT_CONTEXT_FOR_THREAD.pop(threading.current_thread(), None)
        base._CURRENT_THREAD_FOR_CONTEXT.pop(place, None)


def _failures() -> tuple[type[Exception], ...]:
    """Return what the engine and PyOpenGL raise where a GL library fails."""
    import mujoco

    opengl = sys.modules.get("OpenGL.error")
    return (mujoco.FatalError,) if opengl is None else (mujoco.FatalError, opengl.Error)


@functools.cache
def _kind() -> Any:
    """Return the class of renderers; MuJoCo is loaded late."""
    import mujoco

    class Renderer(mujoco.Renderer):
        """Frees what it holds in its own context."""

        def close(self) -> None:
            """Give everything back; more than once changes nothing."""
            if self._mjr_context and self._gl_context:
                with suppress(Exception):  # the library is gone, or another thread has the context
                    self._gl_context.make_current()
            super().close()

        def render(self, *, out: Any = None) -> Any:
            """Return the picture.

            Raises:
                RenderingError: the GL library failed.
            """
            try:
                image = super().render(out=out)
            except _failures() as error:
                raise RenderingError(f"the GL library failed: {one_line(str(error), MESSAGE)}") from error
            _tell_dm_control()
            return image

    return Renderer

"""Which GL library draws: EGL (GPU or software), OSMesa, or a window system, decided by really drawing.

MuJoCo picks a library from MUJOCO_GL while it is being imported; `engine.load` keeps it from that, and here one library
after the other is tried in this process. The name that is set is private to MuJoCo; this file alone knows it.
"""

from __future__ import annotations

import functools
import importlib
import os
import sys
import warnings
from dataclasses import dataclass
from typing import Any

from contarm_sim import libmujoco
from contarm_sim.errors import RenderingError
from contarm_sim.view.rendering.egl import why_egl_fails

PACKAGES = "libegl1 libopengl0 libgl1-mesa-dri"
"""Debian and Ubuntu packages that give a machine without GPU and display a GL library."""

_KNOWN = ("egl", "osmesa", "glfw")

_PROBE = """
<mujoco>
  <worldbody><light pos="0 0 2"/><geom type="sphere" size="1" rgba="1 1 1 1"/></worldbody>
</mujoco>
"""


@dataclass(frozen=True)
class Backend:
    """The GL library in use.

    Attributes:
        name: egl, osmesa or glfw.
        attempts: what was tried, in order: its name and why it failed, None for the one in use.
    """

    name: str
    attempts: tuple[tuple[str, str | None], ...]

    @property
    def note(self) -> str | None:
        """What to say where MUJOCO_GL asks for another library than the one in use."""
        wish = os.environ.get("MUJOCO_GL", "").lower().strip()
        reason = dict(self.attempts).get(wish)
        return f"MUJOCO_GL={wish} is not used: {reason}; drawn with {self.name}" if reason else None


@functools.cache
def choose_backend() -> Backend:
    """Find a GL library that draws, and make `mujoco.Renderer` use it; the answer is kept for the process.

    Tries MUJOCO_GL first if it names one, then EGL, OSMesa and, where there is a display, GLFW.

    Raises:
        RenderingError: none draws; says why each failed and what to install, and carries `attempts` as `Backend` does.
    """
    if os.environ.get("MUJOCO_GL", "").lower().strip() in ("disable", "disabled", "off", "false", "0"):
        raise RenderingError("MUJOCO_GL says not to draw; unset it, or set it to egl or osmesa")
    libmujoco.load()
    platform = os.environ.pop("PYOPENGL_PLATFORM", None)
    attempts: list[tuple[str, str | None]] = []
    wish = os.environ.get("MUJOCO_GL", "").lower().strip()
    if wish not in ("", *_KNOWN):
        attempts.append((wish, f"MUJOCO_GL names no library that there is; {', '.join(_KNOWN)}"))
    if wish == "glfw" and wish not in _candidates():
        attempts.append((wish, "there is no display: neither DISPLAY nor WAYLAND_DISPLAY is set"))
    try:
        for name in _candidates():
            reason = _attempt(name)
            attempts.append((name, reason))
            if reason is None:
                return Backend(name, tuple(attempts))
    finally:
        if platform is None:
            os.environ.pop("PYOPENGL_PLATFORM", None)
        else:
            os.environ["PYOPENGL_PLATFORM"] = platform
    said = ", ".join(f"{name} ({reason})" for name, reason in attempts)
    error = RenderingError(
        f"nothing to draw with: tried {said}; on Debian and Ubuntu this helps: apt-get install {PACKAGES}"
    )
    error.attempts = tuple(attempts)  # type: ignore[attr-defined]
    raise error


def _candidates() -> list[str]:
    """Return the backends worth trying, the user's wish first."""
    names = ["egl", "osmesa"]
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        names.append("glfw")
    wish = os.environ.get("MUJOCO_GL", "").lower().strip()
    return sorted(names, key=lambda name: name != wish)


def _attempt(name: str) -> str | None:
    """Make `mujoco.Renderer` use a backend and draw with it; return why it failed, or None."""
    from mujoco.rendering.classic import gl_context

    if name == "egl" and "mujoco.egl" not in sys.modules:
        reason = why_egl_fails()
        if reason is not None:
            return reason
    before = getattr(gl_context, "GLContext", None)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # GLFW warns of a display it cannot open
            backend = importlib.import_module(f"mujoco.{name}")
            _make_context(backend.GLContext)
            gl_context.GLContext = backend.GLContext
            _prove()
    except Exception as error:  # a missing library shows as almost any exception, AttributeError among them
        if before is None:
            vars(gl_context).pop("GLContext", None)
        else:
            gl_context.GLContext = before
        _forget()
        return _explain(name, error)
    return None


def _make_context(kind: Any) -> None:
    """Make and free a small GL context.

    GLFW "makes" one without a display. MuJoCo must never meet it: it loads its GL functions once a process, and
    aborts the process if asked again after a failure.
    """
    context = kind(64, 64)
    try:
        if not context._context:
            raise RuntimeError("no display")
        context.make_current()
    finally:
        context.free()


def _prove() -> None:
    """Draw a white ball and look at it.

    Raises:
        RuntimeError: the picture is black.
    """
    import mujoco

    model = mujoco.MjModel.from_xml_string(_PROBE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, 16, 16) as renderer:
        renderer.update_scene(data)
        if not renderer.render().any():
            raise RuntimeError("draws nothing")


def _forget() -> None:
    """Undo the imports of a failed backend: PyOpenGL binds itself to one platform when first imported."""
    os.environ.pop("PYOPENGL_PLATFORM", None)
    for name in list(sys.modules):
        if name.startswith(("OpenGL", "mujoco.egl", "mujoco.osmesa")):
            del sys.modules[name]


def _explain(name: str, error: Exception) -> str:
    """Say in a few words why a backend failed."""
    if name == "osmesa" and isinstance(error, AttributeError):
        return "libOSMesa is not installed"
    if name == "glfw":
        return "the display cannot be opened"
    return (str(error).strip() or type(error).__name__).splitlines()[0][:80]

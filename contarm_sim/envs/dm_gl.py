"""dm_control, imported so that it draws with a GL library that there is, and says nothing where there is no display.

dm_control picks the library of MUJOCO_GL while it is imported; without one it takes GLFW, which warns, and draws only
where there is a display.
"""

from __future__ import annotations

import importlib
import os
import sys
import warnings

from contarm_sim import libmujoco
from contarm_sim.view.rendering.context import keep_egl
from contarm_sim.view.rendering.egl import why_egl_fails
from contarm_sim.view.rendering.window import has_display


def load() -> None:
    """Import dm_control's renderers: with the library that MUJOCO_GL names, a window system, EGL, OSMesa, or none.

    Where dm_control is imported already, and took GLFW though nobody asked for it and there is no display, it is given
    what draws here. MUJOCO_GL itself is left as it was found.
    """
    libmujoco.load()
    early = sys.modules.get("dm_control._render")
    if early is not None and (early.BACKEND != "glfw" or has_display() or os.environ.get("MUJOCO_GL")):
        return
    if early is not None:
        sys.modules.pop("dm_control._render")
    before = {name: os.environ.get(name) for name in ("MUJOCO_GL", "PYOPENGL_PLATFORM")}
    try:
        for name in _candidates():
            if name == "egl" and why_egl_fails() is not None:  # an attempt in vain would spoil OSMesa
                continue
            os.environ["MUJOCO_GL"] = name
            if _imported():
                break
    finally:
        for name, value in before.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value
    if early is not None:  # who imported it before asks it again for each picture
        found = sys.modules["dm_control._render"]
        for name in ("Renderer", "BACKEND", "USING_GPU"):
            setattr(early, name, getattr(found, name))
        sys.modules["dm_control._render"] = early
        setattr(sys.modules["dm_control"], "_render", early)  # noqa: B010 (a module of its own to type checkers)
    keep_egl()


def _candidates() -> list[str]:
    """Return the libraries worth trying, the user's wish first; the last one draws nothing."""
    wish = os.environ.get("MUJOCO_GL", "").lower().strip()
    names = [*(["glfw"] if has_display() else []), "egl", "osmesa", "disable"]
    if wish in ("off", "disable", "disabled", "false", "0"):
        return ["disable"]
    return sorted(names, key=lambda name: name != wish)


def _imported() -> bool:
    """Import dm_control with MUJOCO_GL as it is; undo it and return False if that fails."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            importlib.import_module("dm_control._render")
        except Exception:  # a missing library shows as almost any exception
            for name in list(sys.modules):
                if name.startswith(("OpenGL", "dm_control._render")):
                    del sys.modules[name]
            os.environ.pop("PYOPENGL_PLATFORM", None)
            return False
    return True

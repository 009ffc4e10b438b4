"""Does EGL work here? Asked through private handles, so that a "no" leaves no trace in the process.

The real attempt cannot be taken back: PyOpenGL publishes libEGL's symbols to the whole process, and MuJoCo, which
looks for `eglGetProcAddress` first, would from then on draw with a broken EGL instead of OSMesa.
"""

from __future__ import annotations

import ctypes
import os
from ctypes import byref, c_int, c_uint, c_void_p
from typing import Any

_MAX_DEVICES = 10
_PLATFORM_DEVICE = 0x313F
_OPENGL_API = 0x30A2
_NONE = 0x3038
_PBUFFER_OPENGL = (0x3033, 0x0001, 0x3040, 0x0008, 0x3025, 24, _NONE)
"""EGL_SURFACE_TYPE, EGL_RENDERABLE_TYPE and EGL_DEPTH_SIZE as MuJoCo asks for them."""


def why_egl_fails() -> str | None:
    """Make an EGL context as MuJoCo would, and drop it; return in a few words what failed, or None."""
    egl = _library("libEGL.so.1", "libEGL.so")
    if egl is None:
        return "libEGL is not installed"
    if _library("libOpenGL.so.0", "libGL.so.1", "libOpenGL.so", "libGL.so") is None:
        return "libOpenGL is not installed"
    query = _extension(egl, "eglQueryDevicesEXT", c_uint, c_int, c_void_p, c_void_p)
    get_display = _extension(egl, "eglGetPlatformDisplayEXT", c_void_p, c_uint, c_void_p, c_void_p)
    if query is None or get_display is None:
        return "libEGL cannot draw without a display"
    devices, count = (c_void_p * _MAX_DEVICES)(), c_int()
    if not query(_MAX_DEVICES, devices, byref(count)):
        return "libEGL finds no driver"
    candidates = list(devices[: count.value])
    wish = os.environ.get("MUJOCO_EGL_DEVICE_ID")
    if wish is not None:
        if wish not in map(str, range(count.value)):
            return f"MUJOCO_EGL_DEVICE_ID is {wish}, devices: 0 to {count.value - 1}"
        candidates = [candidates[int(wish)]]
    for device in candidates:
        display = get_display(_PLATFORM_DEVICE, device, None)
        if display and egl.eglInitialize(c_void_p(display), None, None):
            # Never terminated: another library of this process may be using the same display.
            return None if _makes_context(egl, c_void_p(display)) else "its driver makes no OpenGL context"
    return "libEGL finds no driver"


def _library(*names: str) -> ctypes.CDLL | None:
    """Load the first library there is, its symbols hidden from the rest of the process."""
    for name in names:
        try:
            return ctypes.CDLL(name, mode=ctypes.RTLD_LOCAL)
        except OSError:
            continue
    return None


def _extension(egl: ctypes.CDLL, name: str, result: Any, *arguments: Any) -> Any:
    """Return a function of an EGL extension, or None."""
    egl.eglGetProcAddress.restype = c_void_p
    address = egl.eglGetProcAddress(name.encode())
    return ctypes.CFUNCTYPE(result, *arguments)(address) if address else None


def _makes_context(egl: ctypes.CDLL, display: c_void_p) -> bool:
    """Return whether a display yields an OpenGL context that can be made current."""
    config, count = c_void_p(), c_int()
    wanted = (c_int * len(_PBUFFER_OPENGL))(*_PBUFFER_OPENGL)
    if not egl.eglChooseConfig(display, wanted, byref(config), 1, byref(count)) or count.value < 1:
        return False
    if not egl.eglBindAPI(c_uint(_OPENGL_API)):
        return False
    egl.eglCreateContext.restype = c_void_p
    context = c_void_p(egl.eglCreateContext(display, config, None, None))
    if not context:
        return False
    current = bool(egl.eglMakeCurrent(display, None, None, context))
    egl.eglMakeCurrent(display, None, None, None)
    egl.eglDestroyContext(display, context)
    return current

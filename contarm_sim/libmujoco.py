"""MuJoCo, imported so that a missing GL library cannot break the physics."""

from __future__ import annotations

import importlib
import os
import sys


def load() -> None:
    """Import mujoco so that no value of MUJOCO_GL can break it; call before anything else imports it.

    MuJoCo loads the library that MUJOCO_GL names while it is imported, and fails if that is missing, even when
    nothing is to be drawn. The variable itself is left as it was found: `rendering.gl` honours it later.
    """
    if "mujoco" in sys.modules:
        return
    wish = os.environ.get("MUJOCO_GL")
    os.environ["MUJOCO_GL"] = "disable"
    try:
        importlib.import_module("mujoco")
    finally:
        if wish is None:
            del os.environ["MUJOCO_GL"]
        else:
            os.environ["MUJOCO_GL"] = wish

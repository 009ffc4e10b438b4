"""MuJoCo Warp, where it is installed: an optional extra, loaded where it is used."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from contarm_sim.errors import MissingError


def library() -> tuple[Any, Any]:
    """Return the modules `warp` and `mujoco_warp`.

    Raises:
        MissingError: they are not installed.
    """
    warp = _warp()
    try:
        with quiet():
            import mujoco_warp
    except ImportError:
        raise MissingError("mujoco-warp", "warp") from None
    return warp, mujoco_warp


@contextmanager
def quiet() -> Iterator[None]:
    """Keep Warp from printing which kernels it compiles, and that there is no CUDA driver."""
    import warp

    before, warp.config.log_level = warp.config.log_level, warp.LOG_ERROR
    try:
        yield
    finally:
        warp.config.log_level = before


def on_cuda() -> bool:
    """Whether there is a CUDA device, on which arms are then stepped.

    Raises:
        MissingError: Warp is not installed.
    """
    warp = _warp()
    with quiet():
        return bool(warp.is_cuda_available())


def described() -> str:
    """Return what there is in words: versions, and the device that arms are stepped on. MuJoCo Warp is not loaded.

    Raises:
        MissingError: it is not installed.
    """
    warp, where = _warp(), "no CUDA device, so on the processor"
    if on_cuda():
        device = warp.get_preferred_device()
        where = f"on {device.name} ({device.alias})"
    try:
        return f"mujoco-warp {version('mujoco-warp')} with Warp {warp.config.version}, {where}"
    except PackageNotFoundError:
        raise MissingError("mujoco-warp", "warp") from None


def made_by() -> str:
    """Return what numbers come from, in words: versions, and the name of the device that arms are stepped on.

    Raises:
        MissingError: it is not installed.
    """
    warp, _ = library()
    device = warp.get_preferred_device().name if on_cuda() else "the processor"
    return f"mujoco-warp {version('mujoco-warp')}, Warp {warp.config.version}, {device}"


def _warp() -> Any:
    try:
        import warp
    except ImportError:
        raise MissingError("mujoco-warp", "warp") from None
    return warp

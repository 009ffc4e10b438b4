"""MuJoCo Warp, where it is installed: an optional extra, loaded where it is used."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from contarm_sim.errors import MissingError


def library() -> tuple[Any, Any]:
    """Return the modules `warp` and `mujoco_warp`.

    Raises:
        MissingError: they are not installed.
    """
    try:
        import warp

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
        MissingError: MuJoCo Warp is not installed.
    """
    warp, _ = library()
    with quiet():
        return bool(warp.is_cuda_available())


def described() -> str:
    """Return what there is in words: versions, and the device that arms are stepped on.

    Raises:
        MissingError: as above.
    """
    warp, mujoco_warp = library()
    where = "no CUDA device, so on the processor"
    if on_cuda():
        device = warp.get_preferred_device()
        where = f"on {device.name} ({device.alias})"
    return f"mujoco-warp {mujoco_warp.__version__} with Warp {warp.config.version}, {where}"

"""Meshes of objects: whether the engine can read them, and whether they are of the arm's size."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from contarm_sim.errors import InputError, one_line
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import MESHES, Object, said_of_object

MOST_LENGTHS = 20
"""Largest extent of a mesh [lengths of the arm]: a larger one is of another unit."""

LEAST_LENGTHS = 1e-4
"""Smallest extent of a mesh [lengths of the arm]."""


def check_mesh(each: Object, arm: Arm) -> None:
    """Refuse a mesh that the engine cannot make, or that is of quite another size than the arm.

    Raises:
        InputError: why not; of one in millimetres, asks about `scale`.
    """
    path = Path(str(each.file)).resolve()
    where, length = said_of_object(each.name), sum(section.length for section in arm.sections)
    try:
        extent = _extent(str(path), each.scale, path.stat().st_mtime_ns, path.stat().st_size)
    except (OSError, ValueError) as error:
        allowed = f"a mesh, binary {' or '.join(MESHES)}, of a body that has a volume"
        raise InputError(
            "file", f"{one_line(str(each.file), 60)!r} ({_why(error, str(path))})", allowed, where
        ) from None
    if LEAST_LENGTHS * length <= extent <= MOST_LENGTHS * length:
        return
    thousandth = extent > MOST_LENGTHS * length >= 1e-3 * extent
    asked = "; is it in millimetres? Then scale = 0.001" if thousandth and each.scale == 1 else ""
    allowed = f"{LEAST_LENGTHS * length:.2g} to {MOST_LENGTHS * length:.3g} m, for this arm{asked}"
    raise InputError("scale", f"{each.scale:g}, which makes it {extent:.4g} m large", allowed, where)


@lru_cache(maxsize=64)
def _extent(file: str, scale: float, changed: int, size: int) -> float:
    """Return the longest edge of a mesh's box [m]; `changed` and `size` tell a file that was written again.

    Raises:
        ValueError: the engine cannot make it.
    """
    spec = mujoco.MjSpec()
    spec.add_mesh(name="mesh", file=file, scale=[scale] * 3)
    spec.worldbody.add_body().add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh", mass=1.0)
    model, turn = spec.compile(), np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[0])  # the engine turns meshes to their principal axes
    return float(np.ptp(model.mesh_vert @ turn.reshape(3, 3).T, axis=0).max())


def _why(error: Exception, file: str) -> str:
    """Return what the engine or the system says of a mesh, in short."""
    if isinstance(error, OSError):
        return error.strerror or "unreadable"
    if "ASCII" in str(error):
        return "not a binary STL, or damaged"
    first = str(error).removeprefix("Error: ").partition("\n")[0].replace(f"'{file}'", "").replace(file, "")
    return one_line(re.sub(r"stl_decoder:|in STL file|: mesh .*|\s(?=[\s,;]|$)", "", first).strip(), 90)

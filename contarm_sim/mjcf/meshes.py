"""Meshes of objects: as the engine reads them, and whether they are of the arm's size."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError, one_line
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import MESHES, Object, said_of_object

Triangles = tuple[np.ndarray, NDArray[np.intp]]
"""Vertices [m], shape (K, 3), and the three of each triangle, shape (F, 3), outwards."""

MOST_LENGTHS = 20
"""Largest extent of a mesh [lengths of the arm]: a larger one is of another unit."""

LEAST_LENGTHS = 1e-4
"""Smallest extent of a mesh [lengths of the arm]."""


def check_mesh(each: Object, arm: Arm) -> None:
    """Refuse a mesh that the engine cannot make, or that is of quite another size than the arm.

    Raises:
        InputError: why not; of one in millimetres, asks about `scale`.
    """
    file, where = str(each.file), said_of_object(each.name)
    length = sum(section.length for section in arm.sections)
    try:
        extent = float(np.ptp(mesh_surface(file, each.scale)[0], axis=0).max())
    except (OSError, ValueError) as error:
        allowed = f"a mesh, binary {' or '.join(MESHES)}, of a body that has a volume"
        given = f"{one_line(file, 60)!r} ({_why(error, str(Path(file).resolve()))})"
        raise InputError("file", given, allowed, where) from None
    if LEAST_LENGTHS * length <= extent <= MOST_LENGTHS * length:
        return
    thousandth = extent > MOST_LENGTHS * length >= 1e-3 * extent
    asked = "; is it in millimetres? Then scale = 0.001" if thousandth and each.scale == 1 else ""
    allowed = f"{LEAST_LENGTHS * length:.2g} to {MOST_LENGTHS * length:.3g} m, for this arm{asked}"
    raise InputError("scale", f"{each.scale:g}, which makes it {extent:.4g} m large", allowed, where)


def mesh_surface(file: str, scale: float) -> Triangles:
    """Return a mesh as its file has it, made once for each version of the file.

    Raises:
        OSError, ValueError: it cannot be read, or has no volume.
    """
    path = Path(file).resolve()
    status = path.stat()
    return _compiled(str(path), scale, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=64)
def _compiled(file: str, scale: float, changed: int, size: int) -> Triangles:
    """Let the engine make a mesh; it keeps it about its own middle, and says where that is.

    Args:
        changed, size: tell a file that was written again.
    """
    spec, turn = mujoco.MjSpec(), np.zeros(9)
    spec.add_mesh(name="mesh", file=file, scale=[scale] * 3)
    spec.worldbody.add_body().add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh", mass=1.0)
    model = spec.compile()
    mujoco.mju_quat2Mat(turn, model.geom_quat[0])
    return model.mesh_vert @ turn.reshape(3, 3).T + model.geom_pos[0], model.mesh_face.astype(np.intp)


def _why(error: Exception, file: str) -> str:
    """Return what the engine or the system says of a mesh, in short."""
    if isinstance(error, OSError):
        return error.strerror or "unreadable"
    if "ASCII" in str(error):
        return "not a binary STL, or damaged"
    first = str(error).removeprefix("Error: ").partition("\n")[0].replace(f"'{file}'", "").replace(file, "")
    return one_line(re.sub(r"stl_decoder:|in STL file|: mesh .*|\s(?=[\s,;]|$)", "", first).strip(), 90)

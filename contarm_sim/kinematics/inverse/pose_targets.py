"""What is asked of three sections, checked: poses, and arms that the closed form knows."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_floats, as_vectors
from contarm_sim.kinematics.backbone import Backbone

_ORTHONORMAL = 1e-6


def check_sections(backbone: Backbone) -> None:
    """Refuse arms of other than three sections that follow each other directly.

    Raises:
        InputError: says so.
    """
    if len(backbone) != 3:
        raise InputError("sections", len(backbone), "3")
    if any(backbone.connectors[:-1]):
        given = list(backbone.connectors)
        raise InputError("connectors", given, "none between sections; a tool at the tip may have any length")


def targets(position: Any, rotation: Any, backbone: Backbone) -> tuple[Array, Array, tuple[int, ...]]:
    """Return checked targets, shapes (n, 3) and (n, 3, 3), and their leading axes.

    Raises:
        InputError: not three sections, numbers that are not finite, other shapes, or no rotation.
    """
    check_sections(backbone)
    position, rotation = as_vectors(position, 3, "position"), as_floats(rotation, 3, "rotation")
    if rotation.ndim < 2 or rotation.shape[-2] != 3:
        raise InputError("rotation", f"of shape {rotation.shape}", "shape (..., 3, 3)")
    shape = common(position.shape[:-1], rotation.shape[:-2], "rotation")
    rotation = _rotations(rotation)
    position = np.broadcast_to(position, (*shape, 3)).reshape(-1, 3)
    return position, np.broadcast_to(rotation, (*shape, 3, 3)).reshape(-1, 3, 3), shape


def common(one: tuple[int, ...], other: tuple[int, ...], name: str,
            must: tuple[int, ...] | None = None) -> tuple[int, ...]:  # fmt: skip
    """Return the leading axes that two arrays share; if `must` is given, they must be these.

    Raises:
        InputError: they do not go together.
    """
    try:
        shape = np.broadcast_shapes(one, other)
    except ValueError:
        shape = None
    if shape is None or must not in (None, shape):
        raise InputError(name, f"leading axes {other}", f"ones that go with those of the targets, {one}")
    return shape


def _rotations(rotation: Array) -> Array:
    """Return rotations made orthonormal to rounding.

    Raises:
        InputError: one is none.
    """
    if not np.isfinite(rotation).all():
        raise InputError("rotation", "not finite", "finite numbers")
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(rotation.swapaxes(-1, -2) @ rotation - np.eye(3)).max(axis=(-1, -2), initial=0.0)
        proper = np.linalg.det(rotation) > 0
    if not np.all(off < _ORTHONORMAL):
        raise InputError("rotation", f"{float(np.max(off)):.3g} off an orthonormal matrix", f"up to {_ORTHONORMAL:g}")
    if not proper.all():
        raise InputError("rotation", "a reflection, its determinant is -1", "rotations, of determinant 1")
    for _ in range(2 if off.max(initial=0.0) > 1e-15 else 0):
        rotation = 0.5 * rotation @ (3 * np.eye(3) - rotation.swapaxes(-1, -2) @ rotation)
    return rotation

"""What is asked of inverse kinematics, checked: targets, and which solution to choose."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.kinematics.backbone import Backbone, as_bends
from contarm_sim.kinematics.inverse.choices import CHOICES
from contarm_sim.kinematics.inverse.goals import Goals

FARTHEST = 1e6
"""Farthest target that is taken, in backbone lengths."""


def as_goals(position: Any, direction: Any, rotation: Any, length: float) -> tuple[Goals, tuple[int, ...]]:
    """Return checked goals, and the leading axes that their arrays share.

    Raises:
        InputError: wrong shapes, not finite, farther than `FARTHEST`, a direction of length 0, no rotation, or both.
    """
    position = as_vectors(position, 3, "position")
    if np.any(np.abs(position) > FARTHEST * length):
        worst = position[(np.abs(position) > FARTHEST * length).any(axis=-1)][0]
        raise InputError("position", worst.tolist(), f"within {FARTHEST:g} backbone lengths")
    if direction is not None and rotation is not None:
        raise InputError("orientation", "both a direction and a rotation", "at most one of them")
    shape = position.shape[:-1]
    if direction is not None:
        direction = as_directions(direction)
        shape = _common("direction", shape, direction.shape[:-1])
        direction = np.broadcast_to(direction, (*shape, 3)).reshape(-1, 3)
    if rotation is not None:
        rotation = _rotations(rotation)
        shape = _common("rotation", shape, rotation.shape[:-2])
        rotation = np.broadcast_to(rotation, (*shape, 3, 3)).reshape(-1, 3, 3)
    return Goals(np.broadcast_to(position, (*shape, 3)).reshape(-1, 3), direction, rotation), shape


def one_goal(position: Any, direction: Any, rotation: Any, length: float) -> Goals:
    """Return the checked goal of one tip.

    Raises:
        InputError: as `as_goals`, or several of them.
    """
    goals, shape = as_goals(position, direction, rotation, length)
    if shape:
        raise InputError("position", f"of shape {(*shape, 3)}", "one target, shape (3,)")
    return goals


def as_near(near: Any, backbone: Backbone, shape: tuple[int, ...]) -> Array | None:
    """Return the bends that solutions are to be nearest to, shape (n, S, 2), or None.

    Raises:
        InputError: no bends, or not as many as targets.
    """
    if near is None:
        return None
    size, bends = len(backbone), as_bends(near, backbone)
    try:
        return np.broadcast_to(bends, (*shape, size, 2)).reshape(-1, size, 2)
    except ValueError:
        raise InputError("near", f"of shape {bends.shape}", f"shape {(*shape, size, 2)}, or one for all") from None


def check_choice(choose: str, near: object = ()) -> None:
    """Refuse an unknown choice, or `nearest` without what it is to be near.

    Raises:
        InputError: one of these.
    """
    if choose not in CHOICES:
        raise InputError("choose", repr(choose), ", ".join(CHOICES))
    if choose == "nearest" and near is None:
        raise InputError("near", "nothing", "bends that the solution is to be nearest to [rad], for choose nearest")


def check_sections(backbone: Backbone, count: int) -> None:
    """Refuse an arm of another number of sections, or one of three that connectors part.

    Raises:
        InputError: says so.
    """
    if len(backbone) != count:
        raise InputError("backbone", f"{len(backbone)} sections", f"{count} sections")
    if count == 3 and any(backbone.connectors[:-1]):
        given = list(backbone.connectors)
        raise InputError("connectors", given, "none between sections; a tool at the tip may have any length")


def as_directions(value: Any) -> Array:
    """Return directions as unit vectors, shape (..., 3).

    Raises:
        InputError: not finite, of another shape, or of length 0.
    """
    value = as_vectors(value, 3, "direction")
    largest = np.abs(value).max(axis=-1, keepdims=True, initial=0.0)
    if not np.all(largest > 0):
        raise InputError("direction", [0.0, 0.0, 0.0], "a vector that is not zero")
    value = value / largest  # squares of very large or small ones would overflow
    return np.asarray(value / np.linalg.norm(value, axis=-1, keepdims=True))


def _rotations(value: Any) -> Array:
    """Return rotation matrices, shape (..., 3, 3), orthonormal to rounding where they were to 1e-6."""
    value = as_vectors(value, 3, "rotation")
    if value.ndim < 2 or value.shape[-2] != 3:
        raise InputError("rotation", f"of shape {value.shape}", "shape (..., 3, 3)")
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(value @ value.swapaxes(-1, -2) - np.eye(3)).max(axis=(-1, -2), initial=0.0)
    if not np.all(off <= 1e-6):
        raise InputError("rotation", value[~(off <= 1e-6)][0].tolist(), "orthonormal rows to 1e-6")
    if not np.all(np.linalg.det(value) > 0):
        raise InputError("rotation", "a mirror image (determinant -1)", "a rotation, determinant 1")
    for _ in range(2 if off.max(initial=0.0) > 1e-15 else 0):
        value = 0.5 * value @ (3 * np.eye(3) - value.swapaxes(-1, -2) @ value)
    return value


def _common(name: str, shape: tuple[int, ...], other: tuple[int, ...]) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(shape, other)
    except ValueError:
        raise InputError(name, f"with leading axes {other}", f"those of the positions, {shape}") from None

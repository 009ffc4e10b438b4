"""Moments that weight and forces at the tip have on bends: generalised forces, by the arcs' Jacobians."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics import arc, sections
from contarm_sim.kinematics.arrays import Array, as_vectors, sinc
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def weight_moment(bend: Any, arm: Arm) -> Array:
    """Return -dV/dbend [N m], shape (..., 2 S): the moment of masses and payload, under the arm's gravity, on bends."""
    gravity = np.array(arm.gravity)
    bends = shape.bends_of(bend, arm)
    xi, weight = 0.5 * (1 + _NODES), 0.5 * _WEIGHTS
    if len(arm.sections) == 1:
        bend = bends[..., 0, :]
        spread = np.einsum("q,...qij->...ij", weight, arc.jacobian(bend[..., None, :], arm.length, xi))
        moved = arm.mass * spread + arm.payload * arc.jacobian(bend, arm.length)
        return np.einsum("i,...ij->...j", gravity, moved)
    starts = np.cumsum([0.0, *(section.length for section in arm.sections[:-1])])
    lengths, masses = (np.array([getattr(part, name) for part in arm.sections]) for name in ("length", "mass"))
    places = np.append((starts[:, None] + lengths[:, None] * xi) / arm.length, 1.0)  # and the tip, in one call
    moved = sections.jacobian(bends[..., None, :, :], shape.backbone(arm), places)[..., :3, :]
    moved = np.einsum("q,...qij->...ij", np.append(masses[:, None] * weight, arm.payload), moved)
    return np.einsum("i,...ij->...j", gravity, moved)


def wrench_moment(bend: Any, force: Any, moment: Any, arm: Arm) -> Array:
    """Return the moment on bends [N m], shape (..., 2 S), of a dead force [N] and couple [N m] at the tip."""
    force, moment = as_vectors(force, 3, "force"), as_vectors(moment, 3, "moment")
    if len(arm.sections) > 1:
        J = sections.jacobian(shape.bends_of(bend, arm), shape.backbone(arm))
        wrench = np.concatenate(np.broadcast_arrays(force, moment), axis=-1)
        return np.asarray((J * wrench[..., :, None]).sum(axis=-2))
    bend = as_vectors(bend, 2, "bend")
    moved = (arc.jacobian(bend, arm.length) * force[..., :, None]).sum(axis=-2)
    # The tip turns by exp([-bend_y, bend_x, 0]^), left Jacobian is sin a/a + (1 - sin a/a) n n^T + (1 - cos a)/a n^.
    angle = np.hypot(bend[..., 0], bend[..., 1])
    by_sine, by_cosine = sinc(angle), 0.5 * sinc(0.5 * angle) ** 2
    vector = np.stack([-bend[..., 1], bend[..., 0], np.zeros_like(angle)], axis=-1)
    rest = np.divide(1 - by_sine, angle**2, out=np.full_like(angle, 1 / 6), where=angle > 1e-4)
    turned = by_sine[..., None] * moment + (rest * (vector * moment).sum(axis=-1))[..., None] * vector
    turned = turned - by_cosine[..., None] * np.cross(vector, moment)
    return moved + np.stack([turned[..., 1], -turned[..., 0]], axis=-1)

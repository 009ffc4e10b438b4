"""Tip error at rest between the poses that were examined: the error vector is a smooth function of the bend."""

from __future__ import annotations

import numpy as np

from contarm_sim.engine.room import engine_room
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.studies.at_rest import Outcome

MANY = 600
"""Of more poses, only the `NEAR` nearest ones tell what is between them."""

NEAR = 60


def error_field(outcome: Outcome, angle: Array, plane: Array) -> Array:
    """Return tip errors [% of length] of one section at bend angles and planes [rad], shapes that go together.

    Through the poses that were examined run cubic radial functions of the bend, one for each axis of the error.
    """
    bend, compared = outcome.samples.bend, outcome.comparison
    vectors = 100 * (compared.simulated_tip - compared.analytic_tip) / outcome.scenario.arm.length
    asked = arc.from_polar(np.asarray(angle), np.asarray(plane))
    between = _near if len(bend) > MANY else _through
    return np.asarray(np.linalg.norm(between(bend, vectors, asked.reshape(-1, 2)), axis=-1).reshape(asked.shape[:-1]))


def _near(at: Array, values: Array, asked: Array) -> Array:
    from scipy.interpolate import RBFInterpolator

    return np.asarray(RBFInterpolator(at, values, kernel="cubic", neighbors=NEAR)(asked))


def _through(at: Array, values: Array, asked: Array) -> Array:
    """Return what cubic radial functions and a plane through values, shape (N, 3), at (N, 2) are at places, (M, 2).

    What SciPy's `RBFInterpolator` returns, whose import alone takes longer.
    """
    count = len(at)
    plane = np.column_stack([np.ones(count), at])
    system = np.block([[_cubes(at, at), plane], [plane.T, np.zeros((3, 3))]])
    parts = np.array_split(asked, max(1, len(asked) * count // 200_000))  # for the processor's cache
    with engine_room():  # one BLAS thread
        weights = np.linalg.solve(system, np.concatenate([values, np.zeros((3, values.shape[1]))]))
        radial = np.concatenate([_cubes(part, at) @ weights[:count] for part in parts])
    return np.asarray(radial + np.column_stack([np.ones(len(asked)), asked]) @ weights[count:])


def _cubes(a: Array, b: Array) -> Array:
    """Return the cubes of distances between places, shape (A, 2) and (B, 2), as (A, B)."""
    square = np.maximum((a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1) - 2 * a @ b.T, 0.0)
    distance = np.sqrt(square)
    return np.asarray(np.multiply(square, distance, out=square))

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
    from scipy.interpolate import RBFInterpolator

    bend, compared = outcome.samples.bend, outcome.comparison
    vectors = 100 * (compared.simulated_tip - compared.analytic_tip) / outcome.scenario.arm.length
    asked = arc.from_polar(np.asarray(angle), np.asarray(plane))
    with engine_room():  # one BLAS thread
        between = RBFInterpolator(bend, vectors, kernel="cubic", neighbors=NEAR if len(bend) > MANY else None)
        found = between(asked.reshape(-1, 2))
    return np.asarray(np.linalg.norm(found, axis=-1).reshape(asked.shape[:-1]))

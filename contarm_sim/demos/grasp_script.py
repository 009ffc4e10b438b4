"""The grasp as a function of time: curl round the log, lift it, put it down, let go."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.demos.curl import Curl, reference_of_curl
from contarm_sim.demos.files import arm_of, knots_of, smooth
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

LIFTED, LOWERING, END = 6.7, 7.7, 14.4
"""When the log is lifted, on its way down, and when it is over [s]."""


def grasp_arm() -> Arm:
    """Return the hanging arm with the log and its forks."""
    return arm_of("grasp")


def bends_at(t: Any) -> Array:
    """Return the bends [rad] of both sections at times [s], shape (T, 4): x and y of section 1, of section 2.

    That of section 2 goes beyond half a turn.
    """
    angles = smooth(*knots_of("grasp"), np.atleast_1d(np.asarray(t, dtype=float)))
    bend = np.zeros((len(angles), 4))
    bend[:, 0::2] = angles
    return bend


def controls_at(t: Any, arm: Arm) -> Array:
    """Return the controls of the length servos [m] at even times from 0 [s], shape (T,); shape (T, 6)."""
    time = np.atleast_1d(np.asarray(t, dtype=float))
    bend, alone = bends_at(time), arm.alone
    return Curl(bend).plan(alone, reference_of_curl(bend, alone, time)).setpoint

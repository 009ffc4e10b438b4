"""Bends of several sections that go around ellipses: one smooth closed curve of each section's bend."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.parameters import as_number


def draw_ellipses(random: np.random.RandomState, count: int) -> Array:
    """Draw an ellipse for each section, shape (S, 3): share that goes forward (0 to 1), phase and turn [rad].

    A share of 0 or 1 makes a circle, of a half a line, to and fro.
    """
    return np.array([[random.random_sample(), *(2 * np.pi * random.random_sample(2))] for _ in range(count)])


def around(largest: Any, ellipses: Any, share: Array, count: int) -> Array:
    """Return bends [rad], shape (T, 2 S), at shares of the way, shape (T,), from 0 to 1.

    As complex numbers, largest (f exp(i (t + phase)) + (1 - f) exp(-i (t + phase))) exp(i turn), f the share forward.

    Args:
        largest: longest half axis there can be [rad].
        ellipses: as `draw_ellipses` gives them.

    Raises:
        InputError: a bend beyond 170 deg, or no such ellipses.
    """
    number = as_number(largest)
    if not 0 < number <= LARGEST_BEND:
        raise InputError("max_bend", largest, f"a number above 0, at most {LARGEST_BEND:.4g} rad")
    try:
        given = np.asarray(ellipses, dtype=float)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape != (count, 3) or not np.isfinite(given).all() or not ((given[:, 0] >= 0) & (given[:, 0] <= 1)).all():
        raise InputError(
            "ellipses", repr(ellipses), f"shape ({count}, 3): share forward from 0 to 1, phase, turn [rad]"
        )
    forward, phase, turn = given.T
    angle = 2 * np.pi * share[:, None] + phase
    way = (forward * np.exp(1j * angle) + (1 - forward) * np.exp(-1j * angle)) * np.exp(1j * turn)
    return np.stack([number * way.real, number * way.imag], axis=-1).reshape(len(share), -1)

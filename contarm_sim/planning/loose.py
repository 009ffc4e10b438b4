"""Families of two and more parameters: samples, and steps from the clearest of them to clearer ones.

There is no order in which to look through such a family, so that nothing found is no proof.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.general.starts import spread
from contarm_sim.kinematics.inverse.limits import clamped
from contarm_sim.planning.search import Found, Search

# Chosen by trial; there is no theory.
_SAMPLES = 128
_BEST, _TRIES, _ROUNDS = 12, 8, 14  # poses that are made clearer, steps that each tries in a round, rounds
_STEP, _SHORTER = 0.5, 0.8  # length of the steps [rad]: from 29 deg down to 0.5 * 0.8^13, 1.6 deg
_STEPS = 12  # of least squares, back to the target


def among(search: Search, known: Array) -> Found:
    """Return the best clear pose that is found, beginning with known solutions, shape (K, S, 2)."""
    bends = np.concatenate([known, _onto(search, spread(_SAMPLES, search.backbone), 40, False)])
    rough = search.look(bends)
    found = search.best(bends, rough)
    rng = np.random.default_rng(0)
    for number in range(_ROUNDS):
        if found is not None:
            break
        order = np.argsort(-rough)[:_BEST]
        bends, rough = bends[order], rough[order]
        step = rng.normal(size=(_TRIES, *bends.shape))
        step *= _STEP * _SHORTER**number / np.sqrt((step**2).sum(axis=(-1, -2), keepdims=True))
        moved = _onto(search, (bends + step).reshape(-1, *bends.shape[1:]), _STEPS, True)
        seen = search.look(moved)
        found = search.best(moved, seen)
        bends, rough = np.concatenate([bends, moved]), np.concatenate([rough, seen])
    return search.ended(found, False)


def _onto(search: Search, bends: Array, steps: int, near: bool) -> Array:
    """Return solutions that bends lead to, shape (K, S, 2); fewer, where some lead to none."""
    goals = search.goal.take(np.zeros(len(bends), dtype=int))
    found = clamped(descend(goals, search.backbone, bends, steps=steps, near=near), search.backbone)
    return np.asarray(found[goals.solved(found, search.backbone)])

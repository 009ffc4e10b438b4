"""The same motion of the arm without what it can touch: what contact moves is the difference."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contarm_sim.control.base import Controller
from contarm_sim.control.registry import controller as resolved
from contarm_sim.errors import InputError, expect
from contarm_sim.motion.simulate import simulate
from contarm_sim.motion.time_step import Stepping
from contarm_sim.results.trajectory import ARRAYS, Trajectory

SAME = 1e-3
"""Largest distance [lengths] of two motions that are the same."""


def without_objects(run: Trajectory, controller: Controller | None = None) -> Trajectory:
    """Return what a motion would have been without objects and self-contact: the same path, controller and time step.

    Of an arm on a base that its host may move, the motion itself is returned: what contact moves is not told there.
    Until the arm first touches something both are the same; a motion that touches nothing is returned as it is, of
    `arm.alone`.

    Args:
        controller: what drove the arm; default the one of the trajectory's name.

    Raises:
        InputError: poses at rest, a motion that was interrupted before its end, or one that cannot be repeated: that
            began in motion, as in the live view, or was driven otherwise.
        DivergenceError, EquilibriumError: as `simulate`.
    """
    expect("run", run, Trajectory)
    if not run.moving:
        raise InputError("run", "poses at rest", "a motion")
    if run.contacts is None or not len(run.contacts) or run.base is not None:
        return replace(run, arm=run.arm.alone, contacts=None, objects=None, base=None, host=None)
    if run.status == "interrupted":
        raise InputError("run", "interrupted", "a motion that was simulated to its end")
    assert run.timestep is not None
    arm, driven = run.arm.alone, controller or resolved(run.controller)
    alone = simulate(arm, run.reference, driven, stepping=Stepping(run.timestep), check_step=False)
    first = int(run.contacts.sample[0])  # before, they differ by rounding
    off = np.abs(run.stations - alone.stations)[: max(first, 1)].max()
    if off > SAME * arm.length:
        given = f"one that differs from it by {1e3 * off:.3g} mm before it touches anything"
        raise InputError("run", given, "a motion that began at rest, and its controller")
    kept: dict[str, Any] = {
        name: np.concatenate([getattr(run, name)[:first], getattr(alone, name)[first:]]) for name in ARRAYS
    }
    return replace(alone, **kept)

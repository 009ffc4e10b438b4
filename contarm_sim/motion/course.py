"""Loads that change while an arm swings: let go at once, over a while, or as a table of forces says."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.load import Load, Wrench

Course = Callable[[float], "float | Load"]
"""Of the time since the release [s]: the share of the load that still acts, or the load itself."""


def remaining(load: Load) -> Load:
    """Return what is left of a load once it is let go: its muscles, driven as they were."""
    return Load(muscles=load.muscles)


def ramp_down(seconds: float) -> Course:
    """Return the share of a load that falls from 1 to 0, evenly, over some time.

    Raises:
        InputError: not a positive time.
    """
    if not (math.isfinite(seconds) and seconds > 0):
        raise InputError("ramp_down", seconds, "a time above 0 s")
    return lambda t: max(0.0, 1.0 - t / seconds)


def forces_over_time(
    times: Sequence[float] | Array, forces: Array, load: Load | None = None, xi: float = 1.0
) -> Course:
    """Return the course of a force at one place, straight lines between rows, its last row kept for good.

    Args:
        times: of the rows since the release, rising from 0 [s], shape (T,).
        forces: dead, in the base frame [N], shape (T, 3).
        load: what acts beside it and stays; default nothing.
        xi: where the force acts, 0 base to 1 tip.

    Raises:
        InputError: times that do not rise from 0, or forces of another shape, or numbers that are not finite.
    """
    at, rows, beside = np.array(times, dtype=float), np.array(forces, dtype=float), load or Load()
    if at.ndim != 1 or not len(at) or at[0] != 0 or not np.all(np.diff(at) > 0) or not np.isfinite(at).all():
        raise InputError("times", "not so", "finite times that rise from 0 s")
    if rows.shape != (len(at), 3) or not np.isfinite(rows).all():
        raise InputError("forces", f"of shape {rows.shape}", f"finite numbers of shape {(len(at), 3)}")
    Wrench(xi=xi)  # says what is wrong with the place

    def course(t: float) -> Load:
        fx, fy, fz = (float(np.interp(t, at, rows[:, axis])) for axis in range(3))
        return replace(beside, wrenches=(*beside.wrenches, Wrench(xi=xi, force=(fx, fy, fz))))

    return course


def load_at(course: Course, load: Load, time: float) -> tuple[Load, float]:
    """Return the load that acts at a time [s], and the share of it that does.

    Raises:
        InputError: neither a finite number nor a load, or a load that drives the muscles in another way.
    """
    now = course(time)
    if isinstance(now, Load):
        if now.muscles != load.muscles:
            raise InputError("course", f"muscles {now.muscles}", f"muscles as they are held: {load.muscles}")
        return now, 1.0
    share = float(now)
    if not math.isfinite(share):
        raise InputError("course", f"{share} at {time:g} s", "a finite share of the load, or a Load")
    return load, share

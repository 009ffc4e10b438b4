"""Is the time step small enough: how far it puts the tip off, where that was estimated from another step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.results.summary import spread
from contarm_sim.results.trajectory import Trajectory


@dataclass(frozen=True)
class TimeStep:
    """The engine's time step and its own error; numbers that nobody knows are None.

    Attributes:
        timestep_s: [s]; None at rest.
        compared: whether the error was estimated anywhere.
        max_m, rms_m, max_percent, rms_percent: the error, as in `Spread`; None beside `compared` if it is infinite.
    """

    timestep_s: float | None
    compared: bool
    max_m: float | None = None
    rms_m: float | None = None
    max_percent: float | None = None
    rms_percent: float | None = None


def step_summary(run: Trajectory) -> TimeStep:
    """Return the time step of a run, and its own error as `run.step_error` has it. Infinite errors fail."""
    errors = run.step_error
    found = np.empty(0) if errors is None else np.asarray(errors, dtype=float)
    found = found[~np.isnan(found)]
    if not len(found) or not np.isfinite(found).all():
        return TimeStep(run.timestep, bool(len(found)))
    return TimeStep(run.timestep, True, **vars(spread(found, run.arm.length)))

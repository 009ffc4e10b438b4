"""Is the time step small enough: how far it puts the tip off, where that was estimated from another step."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.results.compare import spread
from contarm_sim.results.trajectory import Trajectory


def step_summary(run: Trajectory) -> dict[str, Any]:
    """Return the time step [s], and its own error as `run.step_error` has it; None for numbers that nobody knows.

    `compared` tells whether it was estimated anywhere. Errors that are infinite leave numbers None, and fail.
    """
    errors = run.step_error
    found = np.empty(0) if errors is None else np.asarray(errors, dtype=float)
    found = found[~np.isnan(found)]
    missing = dict.fromkeys(("max_m", "rms_m", "max_percent", "rms_percent"))
    if len(found) and not np.isfinite(found).all():
        return {"timestep_s": run.timestep, "compared": True, **missing}
    numbers = spread(found, run.arm.length) if len(found) else missing
    return {"timestep_s": run.timestep, "compared": bool(len(found)), **numbers}

"""Is the time step small enough: how far a run is from the same run with half the step, where that was compared."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.arm import Arm
from contarm_sim.simulation.run import Run
from contarm_sim.validation.compare import spread


def step_summary(arm: Arm, run: Run) -> dict[str, Any]:
    """Return the time step [s], and how far half of it moves the tip; None for numbers that nobody compared.

    `run.step_error` holds tip distances [m], shape (T,), NaN where not compared; or is None.
    """
    errors = getattr(run, "step_error", None)
    found = np.empty(0) if errors is None else np.asarray(errors, dtype=float)
    found = found[~np.isnan(found)]
    missing = dict.fromkeys(("max_m", "rms_m", "max_percent", "rms_percent"))
    if len(found) and not np.isfinite(found).all():
        return {"timestep_s": getattr(run, "timestep", None), "compared": True, **missing}
    numbers = spread(found, arm.length) if len(found) else missing
    return {"timestep_s": getattr(run, "timestep", None), "compared": bool(len(found)), **numbers}

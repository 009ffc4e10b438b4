"""Quantities that no case of a sweep can have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contarm_sim.sweeps.distributions import Values, Varied
from contarm_sim.sweeps.names import Run
from contarm_sim.sweeps.told import has_pressure


def why_never(name: str, run: Run, arm: Any, fixed: Mapping[str, Any], vary: Mapping[str, Varied]) -> str:
    """Return what a quantity is known of, where no case of a sweep is such; or nothing."""
    given = [*fixed, *vary]
    bent = any("bend." in each for each in given)
    if name.startswith("bend_within"):
        varied = vary.get("controller")
        controllers = varied.values if isinstance(varied, Values) else (fixed.get("controller", "servo"),)
        if len(arm.sections) > 1:
            return "left out: it is known of arms of one section"
        if bent or "servo" not in controllers:
            return f"left out: it is known {'without one bend' if bent else 'of controller servo'}"
    if name.startswith("contact_") and not arm.world.touchable:
        return "left out: it is known of arms that can touch something"
    asked = bent or run != "equilibrium"
    if name in ("tip_error", "tip_error_percent") and not asked:
        return "left out: it is known where a bend is asked for (bend.angle)"
    if name == "held" and not asked and not any(each.startswith("load.deltas") for each in given):
        return "left out: it is known where muscles are driven by lengths (bend.angle, load.deltas)"
    if name == "pressure_max" and not has_pressure(arm) and not any(each.endswith("muscle.law") for each in given):
        return "left out: it is known of muscles that have pressure"
    return ""

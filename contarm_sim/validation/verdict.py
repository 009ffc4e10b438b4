"""Thresholds, their reasons, and the verdicts they give: all in one place."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from contarm_sim.arm import Arm

MODEL_LIMIT = 1.0
"""Largest tip error [% of length] at which the constant-curvature model may be said to hold."""

# At 24 links. Over the whole dome the alternating hinges leave 0.0035 % and 0.027 deg, the chain itself 0.09 %;
# they fall with the third, third and second power of the link count.
CHAIN_LIMIT = 0.005
ORIENTATION_LIMIT = 0.05
ARC_LIMIT = 0.1
ORDER_TOLERANCE = 0.1

SAG_MARGIN = 1.25
"""Sag may exceed that of the linear guided beam by this factor: the bent arm is no straight beam."""


@dataclass(frozen=True)
class Check:
    """One number held against its limit."""

    name: str
    value: float
    limit: float
    unit: str
    passed: bool


def at_most(name: str, value: float, limit: float, unit: str) -> Check:
    """Return the check that a value does not exceed its limit; NaN fails."""
    return Check(name, value, limit, unit, bool(value <= limit))


def verdict(checks: list[Check]) -> dict[str, Any]:
    """Return `{verdict: pass | fail, checks: [...]}`."""
    return {
        "verdict": "pass" if all(check.passed for check in checks) else "fail",
        "checks": [asdict(check) for check in checks],
    }


def muscle_checks(summary: dict[str, Any]) -> list[Check]:
    """Return the checks that every muscle pulls, none is slack, and contractions stay within what a braid allows."""
    muscle = summary["muscle"]
    low, high = muscle["allowed_contraction"]
    return [
        at_most("muscles pushing", muscle["pushes"], 0, "samples"),
        at_most("slack", 100 * muscle["slack_fraction"], 0, "% of samples"),
        at_most("contraction", 100 * muscle["max_contraction"], 100 * high, "%"),
        at_most("stretch", -100 * muscle["min_contraction"], -100 * low, "%"),
    ]


def ideal_checks(arm: Arm, summary: dict[str, Any]) -> list[Check]:
    """Return the checks of poses at rest without gravity."""
    coarse = 24 / arm.links
    chain_error = summary["chain_error"]["max_percent"]
    turned = (
        math.degrees((math.pi / arm.links) ** 2 / 4) if arm.links % 2 else 0.0
    )  # one hinge pair has no mirror image
    return [
        at_most("simulated vs chain form", chain_error, CHAIN_LIMIT * coarse**3, "% of length"),
        at_most("simulated vs arc", summary["tip_error"]["max_percent"], ARC_LIMIT * coarse**2, "% of length"),
        at_most("tip orientation", summary["orientation_error_deg"], ORIENTATION_LIMIT * coarse**3 + turned, "deg"),
        *muscle_checks(summary),
    ]


def order_check(order: float) -> Check:
    """Return the check that the discretisation error falls with the second power of the link count."""
    return at_most("observed order of convergence, off 2 by", abs(order - 2), ORDER_TOLERANCE, "-")


def guided_sag(arm: Arm) -> float:
    """Return the tip deflection [m] of a straight guided beam under the arm's weight and payload held sideways.

    Lengths fix the total bend, so the tip cannot turn: q L^4/(24 EI) + P L^3/(12 EI).
    """
    g, stiffness = math.hypot(*arm.gravity), arm.bending_stiffness
    return (arm.mass / 24 + arm.payload / 12) * g * arm.length**3 / stiffness


def loaded_checks(arm: Arm, summary: dict[str, Any]) -> list[Check]:
    """Return the checks of poses at rest under gravity: lengths are held, and the sag is that of a beam."""
    sag = 100 * SAG_MARGIN * guided_sag(arm) / arm.length
    coarse = 24 / arm.links
    return [
        at_most("servo", summary["servo"]["max_percent"], CHAIN_LIMIT, "% of length"),
        at_most("shape (sag)", summary["shape"]["max_percent"], sag + CHAIN_LIMIT * coarse**3, "% of length"),
        *muscle_checks(summary),
    ]


def run_checks(arm: Arm, summary: dict[str, Any]) -> list[Check]:
    """Return the checks of a motion: within the model's limit, plus the sag that the load explains."""
    sag = 100 * SAG_MARGIN * guided_sag(arm) / arm.length
    return [
        at_most("tip error", summary["tip_error"]["max_percent"], MODEL_LIMIT + sag, "% of length"),
        *muscle_checks(summary),
    ]

"""Limits, their reasons, and the two things said of a simulation, apart.

Does constant curvature hold, and within what: an answer, not a failure. And is the simulation explained and converged,
are its targets met: that is checked, and decides the exit code.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from contarm_sim.results.document import shown_if
from contarm_sim.results.summary import ErrorSummary, Spread
from contarm_sim.studies.explained import RodParts

MODEL_LIMIT = 1.0
"""Largest tip error [% of length] at which constant curvature is said to hold."""

UNEXPLAINED_LIMIT = 0.25
"""Most that an ideal rod may leave open [% of length] at 24 links; it grows with the square of the link pitch.

A quarter of `MODEL_LIMIT`, which it may never exceed: what nobody explains must not decide whether constant curvature
holds. Measured: 0.005 on the default spiral, 0.015 hanging with 100 g, 0.11 in three seconds.
"""

SERVO_LIMIT = 1.0
"""Most tip motion by lengths not as commanded [% of length]: beyond, a run tells of the servo."""

FAR_LIMIT = 25.0
"""Largest distance of simulated and analytic tip [% of length]: beyond, the pose has nothing of the arc it is held
against, and a small rest may be luck."""

MOTION_LIMIT = 10.0
"""Largest distance from the pose at rest [% of length]: beyond, the path is too fast for the arm."""

STEP_LIMIT = 0.1
"""Farthest that the time step alone may put the tip off [% of length]: a tenth of `MODEL_LIMIT`."""

MISS_LIMIT = 1.0
"""Farthest a target may lie off the dome of reachable tips [% of length]: beyond, another path is followed."""

SLACK_LIMIT = 1.0
"""Most muscle samples that are slack [%]: a moment's slack moves nothing, a slack muscle steers nothing."""

PUSH_LIMIT = 1.0
"""Most muscle samples that push [%]: muscles cannot, though damping along a slack one does for a moment."""

PUSH_DEPTH_LIMIT = 10.0
"""Largest push [% of the largest tension]: damping alone stays below, an actuator that pushes does not."""

# At 24 links, at rest and without gravity. Over the whole dome the alternating hinges leave 0.0035 % and 0.027 deg, the
# chain itself 0.09 %; they fall with the third, third and second power of the link count.
CHAIN_LIMIT = 0.005
ORIENTATION_LIMIT = 0.05
ARC_LIMIT = 0.1
ORDER_TOLERANCE = 0.1

SECTIONS_LIMITS = (0.01, 0.15)
"""Of several sections, what takes the place of `CHAIN_LIMIT` and `ARC_LIMIT`: each section turns those beyond it."""

Group = Literal["explained", "converged", "targets"]


@dataclass(frozen=True)
class Check:
    """One number held against its limit.

    Attributes:
        value: None where it cannot be had, which fails.
        reason: what it means to be beyond the limit.
        group: what it belongs to.
    """

    name: str
    value: float | None
    limit: float
    unit: str
    passed: bool
    reason: str
    group: Group


def at_most(
    name: str, value: float | None, limit: float, unit: str, reason: str = "", group: Group = "explained"
) -> Check:
    """Return the check that a value does not exceed its limit; None and what is not finite fail."""
    known = value is not None and math.isfinite(value)
    return Check(name, value if known else None, limit, unit, known and bool(value <= limit), reason, group)  # type: ignore[operator]


@dataclass(frozen=True)
class Verdict:
    """What some checks amount to.

    Attributes:
        verdict: pass or fail, of all checks, or in a word why there is none.
        explained, converged, targets_met: whether the checks of a group passed; None without any.
        checks: each of them.
    """

    verdict: str
    explained: bool | None
    converged: bool | None
    targets_met: bool | None
    checks: tuple[Check, ...]


def verdict(checks: list[Check]) -> Verdict:
    """Return the verdict of some checks."""

    def of(group: Group) -> bool | None:
        passed = [check.passed for check in checks if check.group == group]
        return all(passed) if passed else None

    said = "pass" if all(check.passed for check in checks) else "fail"
    return Verdict(said, of("explained"), of("converged"), of("targets"), tuple(checks))


@dataclass(frozen=True)
class ConstantCurvature:
    """Whether constant curvature holds; largest values [% of length], which need not add up.

    Attributes:
        holds: whether the tip error is at most `MODEL_LIMIT`.
        error_percent: the tip error.
        limit_percent: `MODEL_LIMIT`.
        discretisation_percent, sag_percent, motion_percent: its parts, None where they are not known.
        contact_percent: likewise, by what the arm touches.
    """

    holds: bool
    error_percent: float
    limit_percent: float
    discretisation_percent: float | None
    sag_percent: float | None
    motion_percent: float | None
    contact_percent: float | None = field(
        default=None, metadata=shown_if(lambda found: found.contact_percent is not None)
    )


def constant_curvature(errors: ErrorSummary, rod: RodParts, motion: Spread | None = None) -> ConstantCurvature:
    """Return whether constant curvature holds, and the largest tip error and its parts [% of length]."""
    error = errors.tip_error.max_percent
    return ConstantCurvature(
        holds=error <= MODEL_LIMIT,
        error_percent=error,
        limit_percent=MODEL_LIMIT,
        discretisation_percent=errors.discretisation.max_percent,
        sag_percent=None if rod.sag is None else rod.sag.max_percent,
        motion_percent=None if motion is None else motion.max_percent,
        contact_percent=None if errors.contact_error is None else errors.contact_error.max_percent,
    )

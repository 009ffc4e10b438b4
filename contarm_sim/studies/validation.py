"""How far to trust the constant-curvature model: the arm at rest all over its workspace, in every scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import check_count
from contarm_sim.results.document import HIDDEN, INLINE
from contarm_sim.studies.at_rest import NOT_JUDGED, Failure, Outcome
from contarm_sim.studies.attempts import attempts
from contarm_sim.studies.convergence import Convergence, NoConvergence, attempt_convergence
from contarm_sim.studies.progress import Track, quietly
from contarm_sim.studies.scenarios import dome_grid, scenarios, spread_bends


@dataclass(frozen=True, eq=False, repr=False)  # arrays have no single answer to ==
class Validation(Shown):
    """An arm held against the closed forms.

    Attributes:
        bends: that it was held in [rad], shape (T, 2 S).
        outcomes: of the scenarios, by name.
        convergence: of the error with the number of links.
        arm: that was validated.
        verdict: pass if every scenario that is judged passes, and convergence does; else fail.
    """

    bends: Array = field(metadata=HIDDEN)
    outcomes: Mapping[str, Outcome | Failure] = field(metadata=INLINE)
    convergence: Convergence | NoConvergence
    arm: Arm
    verdict: str


LARGEST_OF_SECTIONS = float(np.radians(120))
"""Largest bend of each of several sections, unless another is asked for [rad]."""


def validate(arm: Arm, grid: int = 8, track: Track = quietly, max_bend: float | None = None) -> Validation:
    """Hold the simulated arm against the constant-curvature model, at rest, all over its workspace.

    A scenario in which the arm has no rest pose is a `Failure`, and the others still count.

    Args:
        arm: its own gravity and payload, if it has them, take the place of hanging with 100 g.
        grid: bend angles to the largest, with 3 `grid` bending planes each. Of several sections as many poses, or some
            more, are spread evenly over all their bends.
        track: shows progress.
        max_bend: largest bend angle of a section [rad]; default 170 deg, of several sections 120 deg.

    Raises:
        InputError: no bend angles, or not a whole number of them, a largest that is none, or friction with memory,
            which single poses leave out.
    """
    expect("arm", arm, Arm)
    arm.refuse_memory("arms are validated")
    arm.refuse_objects("arms are validated")
    check_count("grid", grid, 1)
    several = len(arm.sections) > 1
    if max_bend is None:
        max_bend = LARGEST_OF_SECTIONS if several else LARGEST_BEND
    if isinstance(max_bend, bool) or not isinstance(max_bend, (int, float)) or not 0 < max_bend <= LARGEST_BEND:
        raise InputError("max_bend", max_bend, f"more than 0 and at most {LARGEST_BEND:.4g} rad (170 deg)")
    bends = spread_bends(arm, 3 * grid**2, max_bend) if several else dome_grid(grid, max_bend)
    outcomes, converged = attempts(scenarios(arm), bends, track, lambda: attempt_convergence(arm, bends, track))
    verdicts = {each.verdict for each in (*outcomes.values(), converged)}
    return Validation(bends, outcomes, converged, arm, "pass" if verdicts <= {"pass", NOT_JUDGED} else "fail")

"""Where constant curvature may be trusted: errors of many arms, set out by weight, payload, links and bend."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.studies.scenarios import HANGING, weight_over_stiffness
from contarm_sim.studies.trusted_bends import WITHIN
from contarm_sim.sweeps.names import MAX_BEND
from contarm_sim.sweeps.statuses import OK
from contarm_sim.sweeps.table import Sweep

ERROR = "tip_error_max_percent"
BENDS = tuple(f"bend_within_{percent:g}_percent" for percent in WITHIN)
"""Quantities that the chart is made of."""

_MEANING = {False: "hanging", True: "standing up"}


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class Stance:
    """One way to stand.

    Attributes:
        meaning: in words.
        error_percent: the largest tip error at rest of all bends [% of length], shape (X, P, N), by weight, payload and
            links; inf where some pose has no rest.
        bend_deg: the largest bends within the bounds [deg], shape (X, P, N, B), up to where rest ends; NaN where they
            are not known.
    """

    meaning: str
    error_percent: Array
    bend_deg: Array


@dataclass(frozen=True, eq=False)
class Validity:
    """What the validity chart shows.

    Attributes:
        weight: m g L^2/EI of arms without payload [-], shape (X,), rising.
        payload: over the arm's mass [-], shape (P,), from 0.
        links: shape (N,), rising.
        usual: which of the links arms have where nothing else is said.
        bounds: tip errors that are asked about [% of length], rising.
        max_bend_deg: the largest bend that errors count to [deg].
        stances: ways to stand.
        example: m g L^2/EI of an arm to find in it.
        no_rest: why poses have no rest, the most frequent reason first; empty where all have.
    """

    weight: Array
    payload: Array
    links: Array
    usual: int
    bounds: tuple[float, ...]
    max_bend_deg: float
    stances: tuple[Stance, ...]
    example: float
    no_rest: tuple[str, ...] = ()

    @property
    def usual_links(self) -> int:
        """Return the number of links where nothing else is said."""
        return int(self.links[self.usual])

    def weight_within(self, bound: float, stance: int = 0, payload: int = 0) -> float | None:
        """Return the largest m g L^2/EI at which the error stays within a bound [%]; None where no weight is so small.

        Between weights that were tried the logarithms of both are taken to lie on a line.
        """
        errors = self.stances[stance].error_percent[:, payload, self.usual]
        beyond = np.flatnonzero(~(errors <= bound))
        if len(beyond) == 0:
            return float(self.weight[-1])
        first = int(beyond[0])
        if first == 0:
            return None
        if not np.isfinite(errors[first]):
            return float(self.weight[first - 1])
        around = slice(first - 1, first + 1)
        return float(np.exp(np.interp(np.log(bound), np.log(errors[around]), np.log(self.weight[around]))))


MOST_CASES = 50_000
"""Of a sweep with more cases no chart is made."""

_WHY = {
    "unstable": "the arm buckles",
    "no equilibrium": "muscles are too weak",
    "too much pressure": "muscles are too weak",
    "not converged": "none was found",
}
"""Statuses of cases without rest, in words."""

_DIGITS = 9
"""Weights and payloads that agree to so many digits are the same."""


def chart_of(sweep: Sweep) -> Validity | None:
    """Return the validity chart of a sweep, or None if it is none of a kind that has one, or not all of it is there.

    It takes a grid of poses at rest of one section over the dome, with servos; gravity along the straight arm; two
    weights over stiffness, payloads and link counts, or more; largest tip error and bends within bounds asked for.
    """
    from contarm_sim.sweeps.case import case_of

    spec = sweep.spec
    asked = all(name in spec.ask for name in (ERROR, *BENDS))
    if spec.run != "rest" or spec.design != "grid" or not asked or not len(sweep) == spec.cases <= MOST_CASES:
        return None
    try:
        cases = [case_of(spec, values) for values in spec.values(0, spec.cases)]
    except InputError:  # no such arm
        return None
    arms, options = [case.arm for case in cases], [case.options for case in cases]
    largest = {each.get("max_bend", MAX_BEND) for each in options}
    plain = all(each.get("controller", "servo") == "servo" and not _one_bend(each) for each in options)
    if not plain or len(largest) > 1 or any(len(arm.sections) > 1 or arm.gravity[:2] != (0.0, 0.0) for arm in arms):
        return None
    weight, payload, links, stance = places = [
        np.unique(np.array(values), return_inverse=True)
        for values in (
            [float(f"{weight_over_stiffness(replace(arm, payload=0.0)):.{_DIGITS}g}") for arm in arms],
            [float(f"{arm.payload / arm.mass:.{_DIGITS}g}") for arm in arms],
            [arm.links for arm in arms],
            [arm.gravity[2] < 0 for arm in arms],
        )
    ]
    shape = tuple(len(levels) for levels, _ in places)
    if np.prod(shape) != spec.cases or min(shape[:3]) < 2 or weight[0][0] == 0 or payload[0][0] > 0:
        return None
    at: Any = tuple(place for _, place in places)
    error, bends = np.full(shape, np.inf), np.full((*shape, len(BENDS)), np.nan)
    found = sweep.column(ERROR)
    error[at] = np.where(np.isfinite(found), found, np.inf)
    for i, name in enumerate(BENDS):
        bends[..., i][at] = np.degrees(sweep.column(name))
    usual = int(np.abs(links[0] - Arm().links).argmin())
    stances = tuple(
        Stance(_MEANING[bool(upright)], error[:, :, :, k], bends[:, :, :, k]) for k, upright in enumerate(stance[0])
    )
    example = weight_over_stiffness(replace(Arm(), gravity=HANGING))
    degrees = round(math.degrees(largest.pop()), 6)
    why = tuple(dict.fromkeys(_WHY.get(status, status) for status in sweep.counts if status != OK))
    return Validity(weight[0], payload[0], links[0], usual, WITHIN, degrees, stances, example, why)


def _one_bend(options: dict[str, Any]) -> bool:
    return any("bend." in name for name in options)

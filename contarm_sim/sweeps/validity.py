"""Where constant curvature may be trusted: errors of many arms, set out by weight, payload, links and bend."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.kinematics.arrays import Array


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class Stance:
    """One way to stand.

    Attributes:
        meaning: in words.
        error_percent: the largest tip error at rest of all bends [% of length], shape (X, P, N), by weight, payload and
            links; inf where some pose has no rest.
        bend_deg: the largest bends within the bounds [deg], shape (X, P, N, B).
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
    """

    weight: Array
    payload: Array
    links: Array
    usual: int
    bounds: tuple[float, ...]
    max_bend_deg: float
    stances: tuple[Stance, ...]
    example: float

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

"""A static pose as a distribution: many sampled arms, all of which are taken for the nominal one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles
from contarm_sim.statics.continuation import Method
from contarm_sim.statics.driving import checked_values, commands
from contarm_sim.statics.equilibria import equilibria
from contarm_sim.statics.equilibrium import Equilibrium, equilibrium
from contarm_sim.sweeps.causes import Causes
from contarm_sim.sweeps.outcomes import PERCENTS, Outcomes, causes_document, percentiles, uncertain_of
from contarm_sim.sweeps.statuses import status_of
from contarm_sim.sweeps.uncertain import Uncertain

_TOGETHER = 32
"""Cases that are solved at a time."""


@dataclass(frozen=True, eq=False, repr=False)
class UncertainPose(Outcomes):
    """One static pose of many arms that are all taken for the nominal one; n cases run, M muscles.

    Attributes:
        nominal: the pose of the nominal arm.
        tips: tip positions [m], shape (n, 3); NaN where a case has no result.
        tensions: of the muscles [N], shape (n, M), likewise.
        at_limit: whether a length servo is at its limit, shape (n,); False without servos or result.
    """

    nominal: Equilibrium
    tips: Array
    tensions: Array
    at_limit: NDArray[np.bool_]

    @property
    def distance(self) -> Array:
        """Distance from the tip to that of the nominal arm [m], shape (n,)."""
        return np.asarray(np.linalg.norm(self.tips - self.nominal.tip, axis=1))

    @property
    def covariance(self) -> Array:
        """Covariance of the tip's coordinates [m^2], shape (3, 3); NaN of fewer than two tips."""
        tips = self.tips[self.good]
        return np.cov(tips.T) if len(tips) > 1 else np.full((3, 3), np.nan)

    @property
    def ellipsoid(self) -> tuple[Array, Array]:
        """Standard deviations of the tip along the axes of its ellipsoid [m], shape (3,), largest first; these axes.

        The axes are the rows of an array of shape (3, 3).
        """
        if not np.isfinite(self.covariance).all():
            return np.full(3, np.nan), np.full((3, 3), np.nan)
        variances, axes = np.linalg.eigh(self.covariance)
        return np.sqrt(np.maximum(variances[::-1], 0.0)), axes.T[::-1]

    def ellipse(self, across: int, upwards: int) -> Array:
        """Return places [m], shape (100, 2), around 95 % of the normal distribution of two coordinates of the tip."""
        chosen, turn = [across, upwards], np.linspace(0, 2 * np.pi, 100)
        variances, axes = np.linalg.eigh(self.covariance[np.ix_(chosen, chosen)])
        reach = np.sqrt(-2 * np.log(1 - 0.95) * np.maximum(variances, 0.0))  # of chi squared with two freedoms
        circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return np.asarray(self.tips[self.good].mean(axis=0)[chosen] + (reach * circle) @ axes.T)

    @cached_property
    def causes(self) -> dict[str, Causes]:
        """Causes of the spread of the tip (all three coordinates), and of its distance from the nominal tip."""
        return {"tip": self.causes_of(self.tips), "distance": self.causes_of(self.distance)}

    def document(self) -> dict[str, Any]:
        """Return what `--json` prints of it."""
        good, deviations, axes = self.good, *self.ellipsoid

        def told(values: Array) -> Any:
            if not good.any():
                return percentiles([None] * len(PERCENTS))
            return percentiles(np.percentile(values[good], PERCENTS, axis=0).tolist())

        plain = np.isfinite(deviations).all()
        return self.about() | {
            "tip_m": {"nominal": self.nominal.tip.tolist()} | told(self.tips),
            "at_limit": int(self.at_limit.sum()),
            "distance_m": told(self.distance),
            "tensions_n": {"nominal": self.nominal.muscle_tensions.tolist()} | told(self.tensions),
            "ellipsoid": {
                "centre_m": self.tips[good].mean(axis=0).tolist() if plain else None,
                "covariance_m2": self.covariance.tolist() if plain else None,
                "deviations_m": deviations.tolist() if plain else None,
                "axes": axes.tolist() if plain else None,
            },
            "causes": {name: causes_document(each, self.uncertain.names) for name, each in self.causes.items()},
        }

    def columns(self) -> dict[str, tuple[str, Any]]:
        """Return units and values of what a table of the cases has beside their parameters."""
        found: dict[str, tuple[str, Any]] = {"tip_distance": ("m", self.distance)}
        found |= {f"tip_{axis}": ("m", self.tips[:, i]) for i, axis in enumerate("xyz")}
        return found | {f"tension_{i + 1}": ("N", self.tensions[:, i]) for i in range(self.tensions.shape[1])}


def uncertain_pose(
    arm: Arm,
    load: Load | None,
    given: Uncertain | str | Path | Mapping[str, Any],
    method: Method = "auto",
    *,
    on_done: Callable[[int, int], object] | None = None,
) -> UncertainPose:
    """Return the static poses of many arms that a load may act on.

    Args:
        arm: the nominal one.
        load: what acts on them all. Servos get what would hold the bend of the nominal arm.
        given: the uncertain parameters, or a TOML file or mapping of them (see `sweeps.uncertain`).
        method: as of `equilibrium`.
        on_done: called with the number of cases run and that of all, for progress.

    Ctrl-C ends it early: the cases run until then are returned.

    Raises:
        InputError: parameters (see `read_uncertain`) or a load that cannot be.
        EquilibriumError: the nominal arm has no pose at rest.
    """
    arm.refuse_objects("uncertain poses are found")
    load, uncertain = Load() if load is None else load, uncertain_of(arm, given)
    nominal, told = equilibrium(arm, load, method), _told(load, arm)
    tips = np.full((uncertain.cases, 3), np.nan)
    tensions = np.full((uncertain.cases, len(nominal.muscle_tensions)), np.nan)
    at_limit, servos = np.zeros(uncertain.cases, dtype=bool), told.muscles.servos
    said, interrupted = list[tuple[str, str]](), False
    try:
        for first in range(0, uncertain.cases, _TOGETHER):
            found = equilibria(uncertain.arms[first : first + _TOGETHER], told, method=method)
            rows = slice(first, first + len(found))
            tips[rows], tensions[rows] = (
                np.where(found.stable[:, None], values, np.nan) for values in (found.tip, found.muscle_tensions)
            )
            at_limit[rows] = servos & found.stable & ~found.held
            said += [status_of(found.failed.get(case), stable) for case, stable in enumerate(found.stable.tolist())]
            if on_done is not None:
                on_done(len(said), uncertain.cases)
    except KeyboardInterrupt:
        interrupted = True
    status, error = (tuple(each[i] for each in said) for i in (0, 1))
    run = len(said)
    return UncertainPose(uncertain, status, error, interrupted, nominal, tips[:run], tensions[:run], at_limit[:run])


def _told(load: Load, arm: Arm) -> Load:
    """Return a load whose servos get what holds the bend of an arm, whichever arm they are of."""
    if load.muscles.kind not in ("bend", "deltas"):
        return load
    _, setpoints = commands(arm, load.muscles.kind, checked_values(arm, load))
    return replace(load, muscles=Muscles(kind="setpoints", values=tuple(setpoints.tolist())))

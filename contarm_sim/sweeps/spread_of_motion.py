"""The tip error of a motion as a distribution: many sampled arms, all of which are taken for the nominal one.

The controller, its feedback and the closed forms keep the nominal arm, while the simulated arm has the sampled
parameters: that is what happens where an arm is not quite as its data sheet says. What the feedback sees is real.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.control.base import Controller
from contarm_sim.control.believed import Believing
from contarm_sim.control.registry import controller as resolved
from contarm_sim.errors import ContarmError, InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.motion.simulate import Stepping
from contarm_sim.motion.simulate_many import simulate_many
from contarm_sim.paths.reference import section_lengths
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.sweeps.causes import Causes
from contarm_sim.sweeps.outcomes import PERCENTS, Outcomes, causes_document, percentiles, uncertain_of
from contarm_sim.sweeps.statuses import status_of
from contarm_sim.sweeps.uncertain import Uncertain

SHOWN = 24
"""Sampled arms whose backbones are kept for pictures."""

MOST_BYTES = 4 * 2**30
"""Most memory that tips of all cases may take [bytes]."""

_TOGETHER = 16
"""Motions that are simulated at a time: what they record stays in memory, and is lost to Ctrl-C."""

_POINTS, _TIMES = 16, 60
"""Links of a backbone that is kept, and times that the causes of the tip's place are summed over."""


@dataclass(frozen=True, eq=False, repr=False)
class UncertainMotion(Outcomes):
    """One motion of many arms that are all taken for the nominal one; n cases run, T samples.

    Attributes:
        nominal: the motion of the nominal arm.
        tips: tip positions [m], shape (n, T, 3); NaN where a case has no result.
        bones: places along the backbones of some of the arms [m], shape (K, T, P, 3), for pictures.
    """

    nominal: Trajectory
    tips: NDArray[np.float32]
    bones: NDArray[np.float32]

    @cached_property
    def errors(self) -> Array:
        """Distances from the tip to that of the arcs of the nominal arm [m], shape (n, T)."""
        arc = shape.position(self.nominal.bend, self.nominal.arm)
        return np.asarray(np.linalg.norm(self.tips - arc, axis=2))

    @cached_property
    def band(self) -> Array:
        """Percentiles of the tip error at each time [m], shape (3, T)."""
        return np.percentile(self.errors[self.good], PERCENTS, axis=0) if self.good.any() else self._none

    @property
    def _none(self) -> Array:
        return np.full((len(PERCENTS), len(self.nominal)), np.nan)

    @cached_property
    def quantities(self) -> dict[str, Array]:
        """Tip error of each case, mean, max and at the end [m], each of shape (n,)."""
        return _over_time(self.errors)

    @property
    def nominal_error(self) -> dict[str, float]:
        """The same of the nominal arm [m]."""
        return {name: float(value) for name, value in _over_time(self.nominal.tip_error).items()}

    @cached_property
    def causes(self) -> dict[str, Causes]:
        """Causes of the quantities' spread, and of that of the tip itself over time (`tip`)."""
        some = np.unique(np.linspace(0, len(self.nominal) - 1, _TIMES).astype(int))
        asked: dict[str, Any] = self.quantities | {"tip": self.tips[:, some]}
        return {name: self.causes_of(values) for name, values in asked.items()}

    def document(self) -> dict[str, Any]:
        """Return what `--json` prints of it."""
        error, good = {}, self.good
        for name, values in self.quantities.items():
            found = np.percentile(values[good], PERCENTS).tolist() if good.any() else [None] * len(PERCENTS)
            error[name] = {"nominal_m": self.nominal_error[name]} | {
                f"{key}_m": value for key, value in percentiles(found).items()
            }
        told = {name: causes_document(each, self.uncertain.names) for name, each in self.causes.items()}
        return self.about() | {"tip_error": error, "causes": told}

    def columns(self) -> dict[str, tuple[str, Any]]:
        """Return units and values of what a table of the cases has beside their parameters."""
        return {f"tip_error_{name}": ("m", values) for name, values in self.quantities.items()}


def _over_time(errors: Array) -> dict[str, Array]:
    return {"mean": errors.mean(axis=-1), "max": errors.max(axis=-1), "end": errors[..., -1]}


def uncertain_motion(
    nominal: Trajectory,
    given: Uncertain | str | Path | Mapping[str, Any],
    controller: Controller | None = None,
    *,
    stepping: Stepping | None = None,
    on_done: Callable[[int, int], object] | None = None,
) -> UncertainMotion:
    """Return a motion once more, of many arms that it may have been of.

    Args:
        nominal: a motion, as `simulate` returned it: its arm is the nominal one.
        given: the uncertain parameters, or a TOML file or mapping of them (see `sweeps.uncertain`).
        controller: what drove it, if that was of your own.
        stepping: as of `simulate`.
        on_done: called with the number of cases run and that of all, for progress.

    Ctrl-C ends it early: the cases run until then are returned.

    Raises:
        InputError: parameters that cannot be (see `read_uncertain`), poses at rest, or extrapolated ones.
    """
    arm, reference = nominal.arm, nominal.reference
    if not nominal.moving or nominal.extrapolated or len(nominal) < 2:
        raise InputError("nominal", "poses at rest, or extrapolated ones", "a motion as simulate returns it")
    uncertain = uncertain_of(arm, given)
    bytes_ = 4 * 3 * uncertain.cases * len(nominal)
    if bytes_ > MOST_BYTES:
        allowed = f"at most {MOST_BYTES // (12 * len(nominal))} for {len(nominal)} samples"
        raise InputError("cases", uncertain.cases, allowed)
    driver = Believing(resolved(nominal.controller) if controller is None else controller, arm, reference)
    tips = np.full((uncertain.cases, len(nominal), 3), np.nan, dtype=np.float32)
    along = np.unique(np.linspace(0, arm.links, min(arm.links, _POINTS) + 1).astype(int))
    said, bones, interrupted = list[tuple[str, str]](), list[NDArray[np.float32]](), False
    try:
        for first in range(0, uncertain.cases, _TOGETHER):
            arms = uncertain.arms[first : first + _TOGETHER]
            asked = [replace(reference, length=section_lengths(each)) for each in arms]
            for run in simulate_many(arms, asked, driver, stepping=stepping):
                if isinstance(run, ContarmError):
                    said.append(status_of(run))
                    continue
                tips[len(said)] = run.tip
                said.append(status_of(None))
                if len(bones) < SHOWN:
                    bones.append(run.stations[:, along].astype(np.float32))
            if on_done is not None:
                on_done(len(said), uncertain.cases)
    except KeyboardInterrupt:
        interrupted = True
    shown = np.array(bones, dtype=np.float32).reshape(len(bones), len(nominal), len(along), 3)
    status, error = (tuple(each[i] for each in said) for i in (0, 1))
    return UncertainMotion(uncertain, status, error, interrupted, nominal, tips[: len(said)], shown)

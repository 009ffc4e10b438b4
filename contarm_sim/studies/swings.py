"""Let a held arm go, and see whether its swing is to be believed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import InputError, UnstableError, expect
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Wrench
from contarm_sim.motion.modes import SwingModes, swing_modes
from contarm_sim.motion.release import DEFAULT, SwingSettings
from contarm_sim.motion.swing_error import SwingError, judged_release
from contarm_sim.results.document import HIDDEN, INLINE
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.studies.progress import Track, quietly

LIMIT = 0.1
"""Largest mean tip error, of step and links together [% of length]."""

GROWTH = 1e-3
"""Largest growth of energy between samples [shares of what the swing loses]: steps make it waver."""

SIDEWAYS = Load(wrenches=(Wrench(xi=1.0, force=(0.3, 0.0, 0.0)),))
"""What holds the arm unless something else is given."""

MOST_SAMPLES = 100_000


@dataclass(frozen=True, repr=False)
class Release(Shown):
    """A swing, how far it is from the ideal arm's, and whether that is little enough.

    Attributes:
        swing: the samples, and an estimate of their error.
        tip_error_mean_percent: mean tip error that step and links leave together [% of length].
        step_error_mean_percent, links_error_mean_percent: apart.
        observed_order: at which the error falls with the step; None where nothing moves.
        largest_energy_growth_j: between samples [J], 0 if it only falls; None where muscles or a load may do work, or
            nothing damps.
        energy_lost_j: from first to last sample [J]; None likewise.
        modes: natural frequencies, beside those of a clamped beam.
        settings: how it was stepped and recorded.
        arm: that was let go.
        verdict: pass, or fail if the mean tip error exceeds `LIMIT`, or energy grows.
        reasons: why it fails.
    """

    swing: SwingError = field(metadata=HIDDEN)
    tip_error_mean_percent: float
    step_error_mean_percent: float
    links_error_mean_percent: float
    observed_order: float | None
    largest_energy_growth_j: float | None
    energy_lost_j: float | None
    modes: SwingModes = field(metadata=INLINE)
    settings: SwingSettings = field(metadata=INLINE)
    arm: Arm
    verdict: Literal["pass", "fail"]
    reasons: tuple[str, ...]


def release(arm: Arm, load: Load = SIDEWAYS, settings: SwingSettings = DEFAULT, track: Track = quietly) -> Release:
    """Hold an arm by a load, let go, record the swing, and check it against the ideal arm.

    What steps in time leave is estimated from runs of half and a quarter of the step, what links leave from a run of
    half as many. Without muscles energy must not grow.

    Raises:
        EquilibriumError: no stable pose to let go from.
        InputError: settings out of range, a load that cannot be.
        DivergenceError: the engine met a bad state; smaller steps help.
    """
    expect("arm", arm, Arm)
    arm.refuse_objects("released arms swing")
    expect("load", load, Load)
    expect("settings", settings, SwingSettings)
    _check(settings)
    if not equilibrium(arm, load).stable:
        raise UnstableError("the arm has no stable pose under this load to be let go from")
    found = judged_release(arm, load, settings, lambda runs: track(runs, "swinging"))
    energy = found.swing.energy
    passive = load.muscles.kind == "off" and min(s.damping_time for s in arm.sections) > 0 and settings.course is None
    grown, lost = max(float(np.diff(energy).max()), 0.0), float(energy[0] - energy[-1])
    total, step, links = (100 * float(each.mean()) / arm.length for each in (found.total, found.step, found.links))
    reasons = []
    if not total <= LIMIT:
        reasons.append(f"the tip error is {total:.3g} % of length (limit {LIMIT:g}): take smaller steps or more links")
    if passive and not grown <= GROWTH * max(lost, 0.0) + 1e-12 * float(np.abs(energy).max()):
        reasons.append(f"energy grows by {grown:.2g} J: smaller steps")
    return Release(
        swing=found,
        tip_error_mean_percent=total,
        step_error_mean_percent=step,
        links_error_mean_percent=links,
        observed_order=found.order,
        largest_energy_growth_j=grown if passive else None,
        energy_lost_j=lost if passive else None,
        modes=swing_modes(arm, load, settings.timestep),
        settings=settings,
        arm=arm,
        verdict="fail" if reasons else "pass",
        reasons=tuple(reasons),
    )


def _check(settings: SwingSettings) -> None:
    duration, period, timestep = settings.duration, settings.sample_period, settings.timestep
    if not 0.05 <= duration <= 60:
        raise InputError("duration", duration, "0.05 to 60 s")
    if not 1e-5 <= period <= duration:
        raise InputError("sample-period", period, f"1e-5 s to the duration, {duration:g} s")
    if duration / period > MOST_SAMPLES:
        raise InputError("sample-period", period, f"at most {MOST_SAMPLES} samples")
    if not 1e-5 <= timestep <= period:
        raise InputError("timestep", timestep, f"1e-5 s to the sample period, {period:g} s")

"""What a fit leaves open: the covariance of the parameters that it determined, and the noise of what was measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import InputError
from contarm_sim.identify.fitted import FOUND, Fit
from contarm_sim.identify.freedom import Freedom, freedom
from contarm_sim.kinematics.arrays import Array

MEDIAN = 1.65
"""How much less well a median tells a normal distribution's spread than the rms does: fits take the noise from one."""


@dataclass(frozen=True, eq=False, repr=False)
class Covariance(Shown):
    """What a fit leaves open of P parameters of an arm in a rig.

    Attributes:
        freedom: the parameters, about the fitted arm in its rig.
        matrix: of the errors of their vector (logarithms of positive parameters), shape (P, P).
        noise: standard deviation of one measured coordinate [m].
        noise_sd: how well that is known [m].
        held: names of parameters that the data of the fit did not determine: they are held, and counted as known.

    Raises:
        InputError: a covariance of another shape, not finite, or with negative variances.
    """

    freedom: Freedom
    matrix: Array
    noise: float
    noise_sd: float = 0.0
    held: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        count, found = len(self.freedom.free), np.asarray(self.matrix, dtype=float)
        allowed = f"a symmetric array of {count} x {count} finite numbers, variances not below 0"
        if found.shape != (count, count) or not np.isfinite(found).all() or (np.diag(found) < 0).any():
            raise InputError("covariance", f"of shape {found.shape}", allowed)
        if not (np.isfinite(self.noise) and self.noise >= 0):
            raise InputError("noise", self.noise, "a length of 0 m or more")


def covariance_of(fit: Fit, place: int = 0) -> Covariance | None:
    """Return what a fit leaves open of the parameters that it determined, or None where it determined none.

    Args:
        place: number of the recording, from 0, whose rig is meant.
    """
    known = [k for k, one in enumerate(fit.parameters) if one.status in FOUND
             and np.isfinite([one.value, one.sd]).all() and np.isfinite(fit.correlation[k, k])]  # fmt: skip
    own: list[int] = []
    for k in known:
        try:
            freedom(fit.arm, fit.rigs[place], [fit.parameters[k].name])
            own.append(k)
        except InputError:  # of the rig of another recording
            continue
    if not own:
        return None
    free = freedom(fit.arm, fit.rigs[place], [fit.parameters[k].name for k in own])
    sd = np.array([fit.parameters[k].sd for k in own])
    values = np.array([fit.parameters[k].value for k in own])
    sd = np.where(free.logarithmic, sd / np.where(free.logarithmic, values, 1.0), sd)
    correlation = fit.correlation[np.ix_(own, own)]
    held = tuple(one.name for k, one in enumerate(fit.parameters) if k not in known)
    seen = sum(int(np.isfinite(left.error[~np.asarray(left.held_out, dtype=bool)]).sum()) for left in fit.left)
    noise_sd = fit.noise * MEDIAN / np.sqrt(2 * max(seen, 1))
    return Covariance(free, np.nan_to_num(correlation) * np.outer(sd, sd), fit.noise, noise_sd, held)

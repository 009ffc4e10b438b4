"""The numbers of a comparison: how large its distances are, and what the muscles did."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.kinematics import dome
from contarm_sim.kinematics.arrays import Array
from contarm_sim.results.compare import PUSH_TENSION, SLACK_TENSION, Comparison
from contarm_sim.results.trajectory import Trajectory


@dataclass(frozen=True)
class Spread:
    """The largest and the root-mean-square of some distances, in m and in percent of length."""

    max_m: float
    rms_m: float
    max_percent: float
    rms_percent: float


@dataclass(frozen=True)
class MuscleUse:
    """What the muscles did, and what McKibben muscles of these lengths would need for these tensions.

    Attributes:
        min_force_n, max_force_n: tensions [N], pulling > 0.
        pushes: number of muscle samples that push; there is one of every muscle in every sample.
        push_fraction: share of muscle samples that push.
        largest_push_n: [N], 0 where nothing pushes.
        slack_fraction: share of muscle samples that are slack.
        max_pressure_needed_pa: [Pa]; None where no pressure does it. Length servos do not know of pressure.
        below_min_pressure, beyond_max_pressure: number of samples in which a muscle needs less, or more, than there is.
        max_sum_of_deltas_m: largest sum of the length changes [m]; 0 for an arc.
        min_contraction, max_contraction: of rest length [-].
        allowed_contraction: what the braid allows [-].
    """

    min_force_n: float
    max_force_n: float
    pushes: int
    push_fraction: float
    largest_push_n: float
    slack_fraction: float
    max_pressure_needed_pa: float | None
    below_min_pressure: int
    beyond_max_pressure: int
    max_sum_of_deltas_m: float
    min_contraction: float
    max_contraction: float
    allowed_contraction: tuple[float, float]


@dataclass(frozen=True)
class ErrorSummary:
    """A comparison in numbers; distances as in `Comparison`.

    Attributes:
        samples: how many.
        pulls_only, holds_lengths: of the controller, as in `Trajectory`.
        targets_in_millimetres: whether the targets look like millimetres: far off the dome, a thousandth of them on it.
        orientation_error_deg, orientation_error_rms_deg: largest and root-mean-square [deg].
        muscle: what the muscles did.
    """

    samples: int
    pulls_only: bool
    holds_lengths: bool
    target_error: Spread
    tip_error: Spread
    discretisation: Spread
    servo: Spread
    shape: Spread
    backbone_error: Spread
    miss: Spread
    targets_in_millimetres: bool
    orientation_error_deg: float
    orientation_error_rms_deg: float
    muscle: MuscleUse


def spread(distances: Array, length: float) -> Spread:
    """Return the largest and root-mean-square distance [m], and both in percent of length."""
    most, rms = float(distances.max()), float(np.sqrt(np.mean(distances**2)))
    return Spread(most, rms, 100 * most / length, 100 * rms / length)


def known_spread(distances: Array, length: float) -> Spread | None:
    """Return what `spread` does, or None where there are no distances or one is not known."""
    return spread(distances, length) if len(distances) and np.isfinite(distances).all() else None


def summarise(trajectory: Trajectory, comparison: Comparison) -> ErrorSummary:
    """Return the numbers of a comparison: errors, orientation, muscles."""
    length = trajectory.arm.length

    def of(distances: Array) -> Spread:
        return spread(distances, length)

    degrees = np.degrees(comparison.orientation_error)
    return ErrorSummary(
        samples=len(trajectory),
        pulls_only=trajectory.pulls_only,
        holds_lengths=trajectory.holds_lengths,
        target_error=of(comparison.target_error),
        tip_error=of(comparison.tip_error),
        discretisation=of(comparison.discretisation),
        servo=of(comparison.servo),
        shape=of(comparison.shape),
        backbone_error=of(comparison.backbone_error),
        miss=of(comparison.miss),
        targets_in_millimetres=bool(comparison.miss.max() > length) and _in_millimetres(trajectory.target, length),
        orientation_error_deg=float(degrees.max()),
        orientation_error_rms_deg=float(np.sqrt(np.mean(degrees**2))),
        muscle=muscle_use(trajectory),
    )


def _in_millimetres(target: Array, length: float) -> bool:
    """Tell whether a thousandth of targets [m], shape (T, 3), lies within a tenth of length off the dome."""
    return bool(dome.bend_from_tip(1e-3 * target, length, "nearest").miss.max() <= 0.1 * length)


def muscle_use(trajectory: Trajectory) -> MuscleUse:
    """Return what the muscles did."""
    arm, tensions, lengths = trajectory.arm, trajectory.muscle_tensions, trajectory.muscle_lengths
    contraction = 1 - lengths / arm.muscle_rest_length
    pressure, (low, high) = trajectory.pressure, arm.muscle.pressure_limits
    return MuscleUse(
        min_force_n=float(tensions.min()),
        max_force_n=float(tensions.max()),
        pushes=int(np.count_nonzero(tensions < PUSH_TENSION)),
        push_fraction=float(np.mean(tensions < PUSH_TENSION)),
        largest_push_n=max(0.0, -float(tensions.min())),
        slack_fraction=float(np.mean((tensions >= PUSH_TENSION) & (tensions < SLACK_TENSION))),
        max_pressure_needed_pa=float(pressure.max()) if np.isfinite(pressure).all() else None,
        below_min_pressure=int(np.count_nonzero(((pressure > 0) & (pressure < (1 - 1e-6) * low)).any(axis=1))),
        beyond_max_pressure=int(np.count_nonzero((pressure > high).any(axis=1))),
        max_sum_of_deltas_m=float(np.abs(lengths.sum(axis=1) - lengths.shape[1] * arm.length).max()),
        min_contraction=float(contraction.min()),
        max_contraction=float(contraction.max()),
        allowed_contraction=(-arm.muscle.max_stretch, arm.muscle.max_contraction),
    )

"""The numbers of a comparison: how large its distances are, and what the muscles did."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from contarm_sim.kinematics import dome
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.model.arm import Arm
from contarm_sim.results.compare import PUSH_TENSION, SLACK_TENSION, Comparison
from contarm_sim.results.document import shown_if
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
        max_pressure_needed_pa: of the muscles that have pressures [Pa]; None where no pressure does it, or none has
            any. Length servos do not know of pressure.
        below_min_pressure, beyond_max_pressure: number of samples in which a muscle needs less, or more, than there is.
        max_sum_of_deltas_m: largest sum of the length changes of a section's muscles [m]; 0 for an arc.
        min_contraction, max_contraction: of rest length [-].
        allowed_contraction: what the braid allows [-]; where sections differ, what all of them do.
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
class SectionErrors:
    """One section of an arm of several: what the tip moves where that section alone has a part of the error.

    Attributes:
        section: its number, from 1.
        discretisation, servo, shape: the parts, as in `Comparison`; in percent of the whole arm's length.
        muscle: what the muscles that end with it did; None where there are none.
    """

    section: int
    discretisation: Spread
    servo: Spread
    shape: Spread
    muscle: MuscleUse | None


@dataclass(frozen=True)
class ErrorSummary:
    """A comparison in numbers; distances as in `Comparison`.

    Attributes:
        samples: how many.
        pulls_only, holds_lengths: of the controller, as in `Trajectory`.
        targets_in_millimetres: whether the targets look like millimetres: far off the dome, a thousandth of them on it;
            for several sections, a thousandth of them within what the arm is long, and not all at its base.
        orientation_error_deg, orientation_error_rms_deg: largest and root-mean-square [deg].
        muscle: what the muscles did.
        contact_error: how far what the arm touches moves the tip; None where that was not simulated.
        direction_error_deg: largest angle from the direction that was asked for to that of the simulated tip [deg];
            None where none was.
        sections: the same section by section, of an arm of several.
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
    contact_error: Spread | None = field(default=None, metadata=shown_if(lambda e: e.contact_error is not None))
    direction_error_deg: float | None = field(
        default=None, metadata=shown_if(lambda e: e.direction_error_deg is not None)
    )
    sections: tuple[SectionErrors, ...] = field(default=(), metadata=shown_if(lambda errors: errors.sections))


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
        targets_in_millimetres=bool(comparison.miss.max() > length) and _in_millimetres(trajectory),
        orientation_error_deg=float(degrees.max()),
        orientation_error_rms_deg=float(np.sqrt(np.mean(degrees**2))),
        muscle=muscle_use(trajectory),
        contact_error=None if comparison.contact is None else of(comparison.contact),
        direction_error_deg=_direction_error(trajectory),
        sections=_sections(trajectory, comparison),
    )


def _sections(trajectory: Trajectory, comparison: Comparison) -> tuple[SectionErrors, ...]:
    """Return the parts of the error section by section; nothing for one section, which has them all."""
    arm, parts = trajectory.arm, ("section_discretisation", "section_servo", "section_shape")
    if len(arm.sections) == 1:
        return ()
    own = {group.section: part for group, part in zip(arm.groups, muscles.slices(arm), strict=True)}
    found = []
    for number in range(len(arm.sections)):
        links, servo, bent = (spread(getattr(comparison, part)[:, number], arm.length) for part in parts)
        use = muscle_use(trajectory, own[number]) if number in own else None
        found.append(SectionErrors(number + 1, links, servo, bent, use))
    return tuple(found)


def _direction_error(trajectory: Trajectory) -> float | None:
    """Return the largest angle between the directions asked for and the simulated tip's own [deg]; None without any."""
    if trajectory.direction is None:
        return None
    apart = np.linalg.norm(trajectory.direction - trajectory.tip_rotation[..., 2], axis=-1)
    return float(np.degrees(2 * np.arcsin(np.minimum(0.5 * apart, 1.0))).max())


def _in_millimetres(trajectory: Trajectory) -> bool:
    """Tell whether a thousandth of the targets lies within a tenth of length off the dome, or the arm's reach."""
    target, arm = 1e-3 * trajectory.target, trajectory.arm
    if len(arm.sections) > 1:
        return bool(0.05 * arm.length <= np.linalg.norm(target, axis=-1).max() <= 1.1 * arm.length)
    return bool(dome.bend_from_tip(target, arm.length, "nearest").miss.max() <= 0.1 * arm.length)


def muscle_use(trajectory: Trajectory, chosen: slice | None = None) -> MuscleUse:
    """Return what the muscles did.

    Args:
        chosen: which of them; default all.
    """
    chosen, arm = chosen or slice(None), trajectory.arm
    tensions, pressure = trajectory.muscle_tensions[:, chosen], trajectory.pressure[:, chosen]
    lengths = trajectory.muscle_lengths
    contraction = (1 - lengths / muscles.each(arm, lambda group: group.rest_length))[:, chosen]
    low, high, least, most = (limit[chosen] for limit in _limits(arm))
    needed = pressure[:, np.isfinite(high)]
    return MuscleUse(
        min_force_n=float(tensions.min()),
        max_force_n=float(tensions.max()),
        pushes=int(np.count_nonzero(tensions < PUSH_TENSION)),
        push_fraction=float(np.mean(tensions < PUSH_TENSION)),
        largest_push_n=max(0.0, -float(tensions.min())),
        slack_fraction=float(np.mean((tensions >= PUSH_TENSION) & (tensions < SLACK_TENSION))),
        max_pressure_needed_pa=float(needed.max()) if needed.size and np.isfinite(needed).all() else None,
        below_min_pressure=int(np.count_nonzero(((pressure > 0) & (pressure < (1 - 1e-6) * low)).any(axis=1))),
        beyond_max_pressure=int(np.count_nonzero((pressure > high).any(axis=1))),
        max_sum_of_deltas_m=max(
            float(np.abs(lengths[:, own].sum(axis=1) - group.routing.count * group.length).max())
            for group, own in zip(arm.groups, muscles.slices(arm), strict=True)
            if chosen in (slice(None), own)
        ),
        min_contraction=float(contraction.min()),
        max_contraction=float(contraction.max()),
        allowed_contraction=(float(least.max()), float(most.min())),
    )


def _limits(arm: Arm) -> tuple[Array, Array, Array, Array]:
    """Return lowest and highest pressure [Pa], lowest and highest contraction [-] of each muscle, shape (n,) each."""
    return (
        muscles.each(arm, lambda group: group.law.pressure_limits[0]),
        muscles.each(arm, lambda group: group.law.pressure_limits[1]),
        muscles.each(arm, lambda group: -group.law.max_stretch),
        muscles.each(arm, lambda group: group.law.max_contraction),
    )

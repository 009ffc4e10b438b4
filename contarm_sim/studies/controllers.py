"""The spiral under every controller, with and without gravity and payload: what each of them leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim import paths
from contarm_sim.control.registry import NAMES, ControllerName
from contarm_sim.control.tip_motion import plan_rest
from contarm_sim.display import Shown
from contarm_sim.errors import ContarmError, EquilibriumError, InputError, expect
from contarm_sim.kinematics import dome
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number
from contarm_sim.motion.simulate_many import simulate_many
from contarm_sim.paths.reference import RATE, Reference
from contarm_sim.results.summary import muscle_use
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.studies.needs import by_pressure
from contarm_sim.studies.progress import Track, quietly
from contarm_sim.studies.scenarios import under_loads

SETTLED = 1.0
"""Errors count from this time on [s]: a path may start in a sagging pose."""

SHORTEST = 0.5
"""Least duration of the spiral [s]: a shorter one has too few samples for the parts of an error."""

EVERY = 10
"""Errors are split at every tenth sample."""

POSES = 51
"""Of these, poses that are solved for the surface that the tip can reach; splines between."""


@dataclass(frozen=True)
class Followed:
    """How one controller followed the spiral under one load; errors from target to simulated tip.

    Attributes:
        load: free, gravity or payload.
        controller: its name.
        tip_rms_percent, tip_max_percent: errors after `SETTLED`, or half of a shorter path [% of length].
        along_rms_percent: the part along the surface that the tip can reach under that load, likewise.
        lag_s: the delay at which the targets' path fits the tips best [s].
        peak_tension_n: largest tension [N].
        peak_pressure_pa: highest pressure needed [Pa]; None where none does it, or no muscle has any.
        pushes, push_fraction: number and share of muscle samples that push.
        effort_n: mean over time of the sum of the tensions' sizes [N].
    """

    load: str
    controller: str
    tip_rms_percent: float
    tip_max_percent: float
    along_rms_percent: float
    lag_s: float
    peak_tension_n: float
    peak_pressure_pa: float | None
    pushes: int
    push_fraction: float
    effort_n: float


@dataclass(frozen=True)
class NotFollowed:
    """A controller that could not follow the spiral under one load.

    Attributes:
        load, controller: as in `Followed`.
        failed: why.
        needed_pressure_pa: that it takes, if it fails because its muscles have less [Pa]; None for other reasons.
    """

    load: str
    controller: str
    failed: str
    needed_pressure_pa: float | None = None


@dataclass(frozen=True, repr=False)
class ControllerComparison(Shown):
    """The spiral under every controller and load.

    Attributes:
        rows: load by load, every controller; `pressure` only where all muscles have pressures.
        duration: time for the spiral [s].
        arm: that follows it.
    """

    rows: tuple[Followed | NotFollowed, ...]
    duration: float
    arm: Arm


def compare_controllers(arm: Arm, duration: float = 10.0, track: Track = quietly) -> ControllerComparison:
    """Follow the spiral with each controller: free, under gravity, with a payload (its own, or else hanging, 100 g).

    Args:
        duration: time for the spiral [s].
        track: shows progress.

    Raises:
        InputError: a duration below `SHORTEST`, or friction with memory, which simulated motions do not know.
    """
    expect("arm", arm, Arm)
    arm.refuse_memory("simulated motions are")
    arm.refuse_objects("controllers are compared")
    if not as_number(duration) >= SHORTEST:
        raise InputError("duration", duration, f"at least {SHORTEST:g} s")
    arms = under_loads(arm)
    names = [name for name in NAMES if name != "pressure" or by_pressure(arm)]
    jobs = [(load, controller) for load in arms for controller in names]
    spirals = {load: _spiral(each, duration) for load, each in arms.items()}
    reach = {load: _reachable(each, spirals[load]) for load, each in arms.items()}
    steps = iter(track(range(len(jobs)), "controllers"))
    motions = simulate_many(
        [arms[load] for load, _ in jobs],
        [spirals[load] for load, _ in jobs],
        [name for _, name in jobs],
        on_done=lambda index: next(steps, None),
    )
    for _ in steps:
        pass
    rows = [
        _row(load, name, spirals[load], motion, reach[load]) for (load, name), motion in zip(jobs, motions, strict=True)
    ]
    return ControllerComparison(tuple(rows), duration, arm)


def _spiral(arm: Arm, duration: float) -> Reference:
    """Return the spiral; several sections bend as one arc, each by its share of the length."""
    path = paths.named("spiral", arm.length, duration)
    if len(arm.sections) == 1:
        return Reference.from_path(path, arm)
    time, target = path.targets(RATE)
    bend = dome.bend_from_tip(target, arm.length).bend
    shares = np.array([section.length for section in arm.sections]) / arm.length
    return Reference.from_bends(shares[:, None] * bend[:, None], arm, time)


def _reachable(arm: Arm, spiral: Reference) -> Array:
    """Return what projects an error on the surface that the tip can reach, shape (K, 3, 3), at every tenth sample.

    Where that has no rest pose, the dome's. The tip of several sections reaches a volume: nothing is taken off there.
    """
    from scipy.interpolate import CubicSpline

    targets, bend = spiral.target[::EVERY], spiral.bend[::EVERY]
    solved = np.unique(np.linspace(0, len(bend) - 1, POSES).round().astype(int))
    try:
        inverse = np.asarray(plan_rest(arm, bend[solved], targets[solved]).tip_to_bend, dtype=float)
        if len(solved) < len(bend):
            inverse = CubicSpline(solved, inverse)(np.arange(len(bend)))
    except EquilibriumError:
        inverse = np.asarray(np.linalg.pinv(shape.tip_jacobian(bend, arm)))
    return np.linalg.pinv(inverse) @ inverse


def _row(
    load: str, controller: ControllerName, spiral: Reference, samples: Trajectory | ContarmError, reach: Array
) -> Followed | NotFollowed:
    if isinstance(samples, ContarmError):
        return NotFollowed(load, controller, str(samples), getattr(samples, "needed", None))
    arm, time, targets = samples.arm, spiral.time, spiral.target
    tips, after = samples.tip, time >= min(SETTLED, 0.5 * time[-1])
    offset = tips - targets
    along = np.einsum("tij,tj->ti", reach, offset[::EVERY])[after[::EVERY]]
    muscle = muscle_use(samples)
    return Followed(
        load=load,
        controller=controller,
        tip_rms_percent=_rms(offset[after], arm),
        tip_max_percent=100 * float(np.linalg.norm(offset[after], axis=1).max()) / arm.length,
        along_rms_percent=_rms(along, arm),
        lag_s=_lag(time, targets, tips),
        peak_tension_n=muscle.max_force_n,
        peak_pressure_pa=muscle.max_pressure_needed_pa,
        pushes=muscle.pushes,
        push_fraction=muscle.push_fraction,
        effort_n=float(np.abs(samples.muscle_tensions).sum(axis=1).mean()),
    )


def _rms(vectors: Array, arm: Arm) -> float:
    return 100 * float(np.sqrt(np.mean(np.sum(vectors**2, axis=1)))) / arm.length


def _lag(time: Array, targets: Array, tips: Array) -> float:
    """Return the delay [s] at which the targets' path fits the tips best."""
    from scipy.optimize import minimize_scalar

    def misfit(delay: float) -> float:
        late = np.column_stack([np.interp(time - delay, time, column) for column in targets.T])
        inner = slice(len(time) // 10, -len(time) // 10)
        return float(np.sum((late - tips)[inner] ** 2))

    return float(minimize_scalar(misfit, bounds=(-0.2, 0.2), method="bounded", options={"xatol": 1e-5}).x)

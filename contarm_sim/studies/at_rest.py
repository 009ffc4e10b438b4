"""One scenario: the arm at rest over many bends, what it is off by, and whether that is explained."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import mujoco
import numpy as np

from contarm_sim.control.registry import ControllerName
from contarm_sim.display import Shown
from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.errors import DivergenceError, EquilibriumError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.results.compare import Comparison, compare
from contarm_sim.results.document import HIDDEN, INLINE, shown_if
from contarm_sim.results.summary import ErrorSummary, Spread, spread, summarise
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.studies.explained import RodParts, explain
from contarm_sim.studies.progress import Track, quietly
from contarm_sim.studies.relinked import can_double, relinked
from contarm_sim.studies.scenarios import Scenario, weight_over_stiffness
from contarm_sim.studies.verdict import Check, ConstantCurvature, Verdict, constant_curvature, verdict

NO_REST = "no rest pose"
"""The verdict on a scenario that the arm does not rest in everywhere."""
NOT_JUDGED = "not judged"
"""The verdict on a scenario whose numbers are what it is for."""


@dataclass(frozen=True)
class Setting:
    """What a scenario is.

    Attributes:
        meaning: what it shows, in a few words.
        controller: how lengths and set-points are found.
        arm: with the scenario's gravity and payload.
        weight_over_stiffness: (m + payload) g L^2/EI [-]; of several sections, L/EI is the sum of theirs.
    """

    meaning: str
    controller: str
    arm: Arm
    weight_over_stiffness: float


@dataclass(frozen=True, eq=False)  # arrays have no single answer to ==
class LinkError:
    """How far the tip of the worst pose is from that of infinitely many links, and its bend [rad], shape (2 S,)."""

    spread: Spread = field(metadata=INLINE)
    bend: Array


@dataclass(frozen=True, repr=False)
class Outcome(Shown):
    """A scenario at rest.

    Attributes:
        scenario: what was examined.
        samples, comparison: the T poses, and beside the closed forms.
        errors: the comparison in numbers.
        chain_error: simulated tip to the closed form of the chain.
        setting: the scenario in words and numbers.
        real_time_factor: simulated over wall-clock time of bare stepping; None where that blows up.
        link_error: what the number of links leaves; None without gravity, and where other links have no rest.
        rod: what an ideal rod explains of the shape.
        constant_curvature: whether it holds.
        judged: whether the simulation is explained.
    """

    scenario: Scenario = field(metadata=HIDDEN)
    samples: Trajectory = field(metadata=HIDDEN)
    comparison: Comparison = field(metadata=HIDDEN)
    errors: ErrorSummary = field(metadata=INLINE)
    chain_error: Spread
    setting: Setting = field(metadata=INLINE)
    real_time_factor: float | None
    link_error: LinkError | None = field(metadata=shown_if(lambda outcome: any(outcome.setting.arm.gravity)))
    rod: RodParts = field(metadata=INLINE)
    constant_curvature: ConstantCurvature
    judged: Verdict = field(metadata=INLINE)

    @property
    def verdict(self) -> str:
        """Pass, fail, or not judged."""
        return self.judged.verdict


@dataclass(frozen=True, kw_only=True, repr=False)
class Failure(Shown):
    """A scenario in which some pose has no rest; `reason` says which, and why."""

    scenario: Scenario = field(metadata=HIDDEN)
    setting: Setting = field(metadata=INLINE)
    verdict: str = NO_REST
    explained: bool = False
    reason: str
    checks: tuple[Check, ...] = ()


@dataclass(frozen=True, eq=False)
class Rest:
    """A scenario's arm at rest over bends: the T poses, beside the closed forms, and how far these are off."""

    samples: Trajectory
    comparison: Comparison
    errors: ErrorSummary
    chain_error: Spread


def at_rest(scenario: Scenario, bends: Array, track: Track = quietly) -> Rest:
    """Simulate a scenario at rest over bends [rad], shape (T, 2 S).

    Raises:
        EquilibriumError, DivergenceError: the arm has no such rest pose.
    """
    arm = scenario.arm
    try:
        samples = _at_rest(arm, bends, scenario.controller, track(range(len(bends)), scenario.name))
    except EquilibriumError as failure:
        raise failure.located(f"scenario {scenario.name}") from None
    comparison = compare(samples)
    chain_error = spread(np.linalg.norm(comparison.simulated_tip - comparison.chain_tip, axis=-1), arm.length)
    return Rest(samples, comparison, summarise(samples, comparison), chain_error)


def examine(scenario: Scenario, bends: Array, track: Track = quietly) -> Outcome:
    """Simulate a scenario at rest over bends [rad], shape (T, 2 S), and judge it.

    Raises:
        EquilibriumError, DivergenceError: the arm has no such rest pose.
    """
    return timed(judge(scenario, at_rest(scenario, bends, track)))


def judge(scenario: Scenario, rest: Rest) -> Outcome:
    """Say of a scenario at rest what it is off by, and whether that is explained; `timed` adds how fast it steps."""
    arm, errors = scenario.arm, rest.errors
    rod = explain(rest.samples, rest.comparison).summary(arm)
    judged = verdict([] if scenario.checks is None else scenario.checks(arm, errors, rod, rest.chain_error))
    return Outcome(
        scenario=scenario,
        samples=rest.samples,
        comparison=rest.comparison,
        errors=errors,
        chain_error=rest.chain_error,
        setting=setting_of(scenario),
        real_time_factor=None,
        link_error=_link_error(scenario, rest) if any(arm.gravity) else None,
        rod=rod,
        constant_curvature=constant_curvature(errors, rod),
        judged=replace(judged, verdict=NOT_JUDGED) if scenario.checks is None else judged,
    )


def timed(outcome: Outcome) -> Outcome:
    """Return an outcome with its speed of stepping; nothing else may run meanwhile."""
    return replace(outcome, real_time_factor=stepping_speed(outcome.setting.arm, outcome.samples))


def _at_rest(arm: Arm, bends: Array, controller: ControllerName, ticks: Iterable[int] | None = None) -> Trajectory:
    return poses_at_rest(arm, Reference.from_bends(bends, arm), controller, ticks)


def setting_of(scenario: Scenario) -> Setting:
    """Return what a scenario is, in words and numbers."""
    arm = scenario.arm
    return Setting(scenario.meaning, scenario.controller, arm, weight_over_stiffness(arm))


def stepping_speed(arm: Arm, samples: Trajectory, steps: int = 300) -> float | None:
    """Return simulated over wall-clock time of bare stepping in the last pose, with the default step.

    None where that blows up.
    """
    plant = Plant(arm)
    plant.data.qpos[:], plant.data.ctrl[:] = samples.qpos[-1], samples.setpoint[-1]
    with engine_room():
        start = time.perf_counter()
        mujoco.mj_step(plant.model, plant.data, steps)
        elapsed = time.perf_counter() - start
    try:
        plant.check({"timestep": plant.model.opt.timestep})
    except DivergenceError:
        return None
    return steps * plant.model.opt.timestep / elapsed


def _link_error(scenario: Scenario, rest: Rest) -> LinkError | None:
    """Return how far the tip of the worst pose is from that of infinitely many links.

    None where the arm of other links has no rest. Estimated from twice (or, past the limit, half) the links, the error
    being of second order. Under load this is more than the closed-form discretisation, which knows of no sag: coarse
    spans make the arm a little softer.
    """
    worst, arm = int(rest.comparison.tip_error.argmax()), scenario.arm
    bend, tip, double = rest.samples.bend[worst], rest.comparison.simulated_tip[worst], can_double(arm)
    try:
        samples = _at_rest(relinked(arm, double), bend[None], scenario.controller)
    except (EquilibriumError, DivergenceError):
        return None
    error = np.linalg.norm(samples.tip - tip, axis=-1) * (4 / 3 if double else 1 / 3)
    return LinkError(spread(error, scenario.arm.length), bend)

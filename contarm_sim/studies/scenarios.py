"""The arm at rest over the whole dome: without gravity, hanging, upright, loaded, and driven naively."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.errors import ConvergenceError, DivergenceError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import MAX_LINKS, Arm
from contarm_sim.model.arm_file import arm_to_dict
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.results.compare import Comparison, compare, spread, summarise
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.studies.checks import ideal_checks, loaded_checks
from contarm_sim.studies.explained import explain
from contarm_sim.studies.verdict import Check, constant_curvature, verdict

LARGEST_BEND = math.radians(170)
HANGING = (0.0, 0.0, 9.81)
UPRIGHT = (0.0, 0.0, -9.81)
PAYLOAD = 0.1
NO_REST = "no rest pose"
"""The verdict on a scenario that the arm does not rest in everywhere."""
NOT_JUDGED = "not judged"
"""The verdict on a scenario whose numbers are what it is for."""

Track = Callable[[Iterable[int], str], Iterable[int]]


@dataclass(frozen=True)
class Scenario:
    """One arm under one load, driven one way.

    Attributes:
        name: what it is called in summaries.
        meaning: what it shows, in a few words.
        arm: with this scenario's gravity and payload.
        controller: how lengths and set-points are found.
        checks: from arm and summary to checks; None: not judged.
    """

    name: str
    meaning: str
    arm: Arm
    controller: str
    checks: Callable[[Arm, dict[str, Any]], list[Check]] | None


@dataclass(frozen=True)
class Outcome:
    """A scenario's samples, comparison and numbers."""

    scenario: Scenario
    samples: Trajectory
    comparison: Comparison
    summary: dict[str, Any]


@dataclass(frozen=True)
class Failure:
    """A scenario in which some pose has no rest; its summary says which, as `reason`."""

    scenario: Scenario
    summary: dict[str, Any]


def dome_grid(grid: int) -> Array:
    """Return bends [rad] over the dome, shape (3 grid^2 + 1, 2).

    Straight, then `grid` angles to 170 deg by 3 `grid` planes.
    """
    angles = LARGEST_BEND * np.arange(1, grid + 1) / grid
    planes = 2 * np.pi * np.arange(3 * grid) / (3 * grid)
    bends = arc.from_polar(angles[:, None], planes)
    return np.concatenate([np.zeros((1, 2)), bends.reshape(-1, 2)])


def under_load(arm: Arm) -> tuple[Arm, Arm]:
    """Return an arm under gravity alone and with a payload too: its own, or else hanging, with 100 g."""
    pulled = replace(arm, gravity=arm.gravity if any(arm.gravity) else HANGING, payload=0.0)
    return pulled, replace(pulled, payload=arm.payload or PAYLOAD)


def scenarios(arm: Arm) -> list[Scenario]:
    """Return the scenarios of an arm; its own gravity, if it has one, takes the place of hanging."""
    free, own = arm.unloaded, any(arm.gravity)
    pulled, loaded = under_load(arm)
    kg = f"{loaded.payload:g} kg"
    given = [
        Scenario("ideal", "no gravity", free, "servo", ideal_checks),
        Scenario("naive", "no gravity, paper's lengths, plain servos", free, "paper", None),
        Scenario("gravity", "the arm's gravity" if own else "hanging", pulled, "servo", loaded_checks),
        Scenario("payload", f"{'the same' if own else 'hanging'} with {kg}", loaded, "servo", loaded_checks),
    ]
    if not own:
        upright = replace(pulled, gravity=UPRIGHT)
        given.append(Scenario("upright", "standing under its own weight", upright, "servo", loaded_checks))
    return given


def examine(scenario: Scenario, bends: Array, track: Track) -> Outcome:
    """Simulate a scenario at rest over bends [rad], shape (T, 2), and judge it.

    Raises:
        ConvergenceError, DivergenceError: the arm has no such rest pose.
    """
    arm = scenario.arm
    reference = Reference.from_bends(bends, arm)
    ticks = track(range(len(bends)), scenario.name)
    try:
        samples = poses_at_rest(arm, reference, scenario.controller, ticks)
    except ConvergenceError as failure:
        raise failure.located(f"scenario {scenario.name}") from None
    comparison = compare(samples)
    summary = summarise(samples, comparison)
    to_chain = np.linalg.norm(comparison.simulated_tip - comparison.chain_tip, axis=-1)
    summary["chain_error"] = spread(to_chain, arm.length)
    summary |= {**_described(scenario), "real_time_factor": stepping_speed(arm, samples)}
    if any(arm.gravity):
        worst = int(comparison.tip_error.argmax())
        error = _link_error(scenario, bends[worst], comparison.simulated_tip[worst])
        known = None if error is None else {**spread(error, arm.length), "bend": bends[worst].tolist()}
        summary["link_error"] = known
    summary |= explain(samples, comparison).summary(arm)
    summary["constant_curvature"] = constant_curvature(summary)
    judged = verdict([] if scenario.checks is None else scenario.checks(arm, summary))
    summary |= judged if scenario.checks is not None else judged | {"verdict": NOT_JUDGED}
    return Outcome(scenario, samples, comparison, summary)


def attempt(scenario: Scenario, bends: Array, track: Track) -> Outcome | Failure:
    """Do as `examine`, and return the failure where the arm has no rest pose: the other scenarios still count."""
    try:
        return examine(scenario, bends, track)
    except (ConvergenceError, DivergenceError) as error:
        reason = str(error).removeprefix(f"scenario {scenario.name}: ")
        judged = {"verdict": NO_REST, "explained": False, "reason": reason, "checks": []}
        return Failure(scenario, _described(scenario) | judged)


def _described(scenario: Scenario) -> dict[str, Any]:
    arm = scenario.arm
    weight = (arm.mass + arm.payload) * math.hypot(*arm.gravity)
    found = {"meaning": scenario.meaning, "controller": scenario.controller, "arm": arm_to_dict(arm)}
    return found | {"weight_over_stiffness": weight * arm.length**2 / arm.bending_stiffness}


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


def _link_error(scenario: Scenario, bend: Array, tip: Array) -> Array | None:
    """Return how far a tip [m] at one bend [rad] is from that of infinitely many links [m], shape (1,).

    None where the arm of other links has no rest. Estimated from twice (or, past the limit, half) the links, the error
    being of second order. Under load this is more than the closed-form discretisation, which knows of no sag: coarse
    spans make the arm a little softer.
    """
    links = scenario.arm.links
    double = 2 * links <= MAX_LINKS
    other = replace(scenario.arm, links=2 * links if double else links // 2)
    try:
        samples = poses_at_rest(other, Reference.from_bends(bend[None], other), scenario.controller)
    except (ConvergenceError, DivergenceError):
        return None
    return np.linalg.norm(samples.stations[:, -1] - tip, axis=-1) * (4 / 3 if double else 1 / 3)

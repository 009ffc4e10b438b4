"""Scenarios of which some may have no rest: the others still count, and each is judged beside the next."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import Future
from typing import TypeVar

from contarm_sim.engine.threads import pool
from contarm_sim.errors import DivergenceError, EquilibriumError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.studies.at_rest import Failure, Outcome, at_rest, judge, setting_of, timed
from contarm_sim.studies.progress import Track, quietly
from contarm_sim.studies.scenarios import Scenario

T = TypeVar("T")


def attempt(scenario: Scenario, bends: Array, track: Track = quietly) -> Outcome | Failure:
    """Do as `examine`, and return the failure where the arm has no rest pose."""
    return attempts([scenario], bends, track, lambda: None)[0][scenario.name]


def attempts(
    scenarios: Iterable[Scenario], bends: Array, track: Track, besides: Callable[[], T]
) -> tuple[dict[str, Outcome | Failure], T]:
    """Examine scenarios by name, each judged while the next is simulated; where an arm has no rest, return that.

    Args:
        besides: something else to do, while the last is judged; its result is returned too.
    """
    found: dict[str, Outcome | Failure] = {}
    with pool(1) as beside:
        waiting: dict[str, Future[Outcome]] = {}
        for scenario in scenarios:
            found[scenario.name] = _failed(scenario, "")  # its place
            try:
                waiting[scenario.name] = beside.submit(judge, scenario, at_rest(scenario, bends, track))
            except (EquilibriumError, DivergenceError) as error:
                found[scenario.name] = _failed(scenario, str(error))
        other = besides()
        judged = {name: each.result() for name, each in waiting.items()}
    return found | {name: timed(each) for name, each in judged.items()}, other


def _failed(scenario: Scenario, reason: str) -> Failure:
    said = reason.removeprefix(f"scenario {scenario.name}: ")
    return Failure(scenario=scenario, setting=setting_of(scenario), reason=said)

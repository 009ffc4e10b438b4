"""Run cases, those of a chunk together where that is faster; each comes to what it would alone, to the bit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from contarm_sim.engine.threads import at_most
from contarm_sim.model.load import Load
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate_many import simulate_many
from contarm_sim.motion.time_step import Stepping
from contarm_sim.paths.reference import Reference
from contarm_sim.statics.equilibria import equilibria
from contarm_sim.sweeps.case import Case, bend_of
from contarm_sim.sweeps.names import Run
from contarm_sim.sweeps.quantities import DETAILS
from contarm_sim.sweeps.spec import Spec
from contarm_sim.sweeps.told import Followed, Rested, Told


def told(spec: Spec, cases: Sequence[Case | Exception]) -> list[Told | Exception]:
    """Return what each case tells; where there is an error, that."""
    good = [place for place, case in enumerate(cases) if isinstance(case, Case)]
    found: list[Any] = list(cases)
    with at_most(1):  # chunks are what processors share
        each_told = _apart(spec, [found[place] for place in good])
    for place, each in zip(good, each_told, strict=True):
        found[place] = each
    return found


def _apart(spec: Spec, cases: list[Case]) -> list[Any]:
    """Run cases together; where that fails as a whole, one by one, so that the error is said of its own case."""
    found = tried(_RUN[spec.run], spec, cases)
    if not isinstance(found, Exception):
        return list(found)
    return [found] if len(cases) == 1 else [each for case in cases for each in _apart(spec, [case])]


def tried(function: Callable[..., Any], *given: Any) -> Any:
    """Return what a function does, or the error that it raises: of which case that is, is known to the caller."""
    try:
        return function(*given)
    except Exception as error:
        return error


def _at_rest(spec: Spec, cases: list[Case]) -> list[Any]:
    def one(case: Case) -> Told:
        return Followed(case.arm, poses_at_rest(case.arm, case.poses(), case.controller))

    return [tried(one, case) for case in cases]


def _equilibria(spec: Spec, cases: list[Case]) -> list[Any]:
    """Solve all poses together."""
    loads = [tried(Case.load, case) for case in cases]
    good = [place for place, load in enumerate(loads) if isinstance(load, Load)]
    if not good:
        return loads
    arms = [cases[place].arm for place in good]
    every = equilibria(arms, [loads[place] for place in good], details=bool(set(spec.ask) & set(DETAILS)))
    found = list(loads)
    for row, place in enumerate(good):
        case = cases[place]
        found[place] = every.failed.get(row) or Rested(case.arm, every, row, bend_of(case.options, case.arm))
    return found


def _motions(spec: Spec, cases: list[Case]) -> list[Any]:
    """Step all motions together."""
    found: list[Any] = [tried(_motion, case) for case in cases]
    good = [place for place, motion in enumerate(found) if not isinstance(motion, Exception)]
    if good:
        references, steppings = zip(*(found[place] for place in good), strict=True)
        arms, controllers = zip(*((cases[place].arm, cases[place].controller) for place in good), strict=True)
        flown = simulate_many(arms, references, controllers, stepping=steppings, backend=spec.backend)
        for place, each in zip(good, flown, strict=True):
            found[place] = each if isinstance(each, Exception) else Followed(cases[place].arm, each)
    return found


def _motion(case: Case) -> tuple[Reference, Stepping | None]:
    return case.motion(), case.stepping()


_RUN: dict[Run, Callable[[Spec, list[Case]], list[Any]]] = {
    "rest": _at_rest,
    "equilibrium": _equilibria,
    "motion": _motions,
}

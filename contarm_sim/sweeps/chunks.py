"""Cases are run in chunks: which, how, and what a row of the table says of each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from contarm_sim.engine.room import engine_room
from contarm_sim.errors import ContarmError, MissingError, one_line
from contarm_sim.studies.trusted_bends import WITHOUT_REST
from contarm_sim.sweeps.case import Case, case_of
from contarm_sim.sweeps.designs import roles
from contarm_sim.sweeps.quantities import QUANTITIES, Quantity
from contarm_sim.sweeps.spec import Spec
from contarm_sim.sweeps.statuses import of_case, status_of
from contarm_sim.sweeps.together import told, tried
from contarm_sim.sweeps.told import Lost, Told

SECONDS = 2.0
"""Work of a chunk that is aimed at, on one core [s]: what a killed sweep loses at most for each process."""

AT_LEAST, AT_MOST = 16, 10_000
"""Fewest chunks of a sweep, if it has as many cases, and most."""

DEVICE = 1024
"""Cases of a chunk on a graphics card."""

Row = dict[str, Any]


@lru_cache(maxsize=8)
def chunk_size(spec: Spec) -> int:
    """Return how many cases a chunk has: by what they cost, as the sweep alone tells."""
    if spec.backend != "cpu":
        return min(spec.cases, DEVICE)
    size = min(math.ceil(SECONDS / _cost(spec)), math.ceil(spec.cases / AT_LEAST))
    return max(size, math.ceil(spec.cases / AT_MOST))


def _cost(spec: Spec) -> float:
    """Return about how long a case takes [s]: the longer of first and last."""
    costs = [1e-3]
    for case in {0, spec.cases - 1}:
        try:
            one = case_of(spec, spec.values(case, case + 1)[0])
            share = one.arm.links / 24
            if spec.run == "rest":
                costs.append(0.4e-3 * share * len(one.poses()))
            elif spec.run == "equilibrium":
                costs.append(2e-3 * share)
            else:
                costs.append(0.03 * share * float(one.motion().time[-1]))
        except Exception:  # said where it is run
            continue
    return max(costs)


def chunk_count(spec: Spec) -> int:
    """Return how many chunks a sweep has."""
    return math.ceil(spec.cases / chunk_size(spec))


def rows(spec: Spec, chunk: int) -> list[Row]:
    """Run the cases of a chunk; return a row of the table for each, in order.

    Raises:
        ContarmError: a case met an error that says nothing of the case; names it.
    """
    size = chunk_size(spec)
    first, last = chunk * size, min((chunk + 1) * size, spec.cases)
    every = spec.values(first, last)
    asked = [QUANTITIES[spec.run][name] for name in spec.ask]
    with engine_room():
        cases = [tried(case_of, spec, values) for values in every]
        made = [
            {"case": number, **values, **_of_arm(case, asked), **_said(number, case, each, asked)}
            for number, values, case, each in zip(range(first, last), every, cases, told(spec, cases), strict=True)
        ]
    if spec.design == "sobol-indices":
        for row, point, matrix in zip(made, *roles(list(spec.vary), first, last), strict=True):
            row |= {"point": point, "matrix": matrix}
    return made


def _of_arm(case: Case | Exception, asked: Sequence[Quantity]) -> Row:
    """Return the quantities that the arm alone tells; none where there is no such arm."""
    if isinstance(case, Exception):
        return {}
    return {quantity.name: quantity.of(Told(case.arm)) for quantity in asked if quantity.of_arm}


def _said(number: int, case: Case | Exception, found: Told | Exception, asked: Sequence[Quantity]) -> Row:
    """Return the quantities, the status and the error of a case."""
    made: Row = {}
    if not isinstance(found, Exception):
        try:
            made, problem, stable = {quantity.name: quantity.of(found) for quantity in asked}, None, found.stable
        except Exception as error:
            found = error
    if isinstance(found, Exception):
        if isinstance(found, MissingError):
            raise found
        if not of_case(found):
            raise ContarmError(f"case {number}: {type(found).__name__}: {one_line(str(found))}") from found
        costly = [quantity for quantity in asked if quantity.costly]
        made = _up_to_rest(case, costly) if costly and isinstance(found, WITHOUT_REST) else {}
        problem, stable = found, False
    status, error_text = status_of(problem, stable)
    return made | {"status": status, "error": error_text or None}


def _up_to_rest(case: Case | Exception, asked: Sequence[Quantity]) -> Row:
    """Return bends of an arm that has no rest in some pose: they are searched for up to where rest ends."""
    if isinstance(case, Exception) or case.controller != "servo":
        return {}
    lost = Lost(case.arm, case.poses().bend)
    found = {quantity.name: tried(quantity.of, lost) for quantity in asked}
    return {name: value for name, value in found.items() if not isinstance(value, Exception)}

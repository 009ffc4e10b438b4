"""How the discretisation error falls with the number of links: with the second power, or something is wrong."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

from contarm_sim.errors import ConvergenceError, DivergenceError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.studies.scenarios import NO_REST, Scenario, Track, examine
from contarm_sim.studies.verdict import ORDER_TOLERANCE, at_most, verdict


def refinements(links: int) -> list[int]:
    """Return three link counts, each twice the one before, that hold or surround `links`."""
    if links > 96:
        return [links // 4, links // 2, links]
    return [links // 2, links, 2 * links] if links >= 12 else [links, 2 * links, 4 * links]


def convergence(arm: Arm, bends: Array, track: Track) -> dict[str, Any]:
    """Return the largest tip error against the arc over bends, for three link counts, and the observed orders.

    Raises:
        ConvergenceError, DivergenceError: one of the arms has no such rest pose.
    """
    counts, errors, chain_errors = refinements(arm.links), [], []
    for links in counts:
        scenario = Scenario(f"{links} links", "no gravity", replace(arm.unloaded, links=links), "servo", None)
        outcome = examine(scenario, bends, track)
        errors.append(outcome.summary["tip_error"]["max_m"])
        chain_errors.append(outcome.summary["chain_error"]["max_m"])
    pairs = zip(itertools.pairwise(errors), itertools.pairwise(counts), strict=True)
    orders = [math.log(e0 / e1) / math.log(n1 / n0) for (e0, e1), (n0, n1) in pairs]
    off = abs(orders[-1] - 2)
    reason = "the chain does not approach the arc as straight links do"
    check = at_most("order of convergence, off 2 by", off, ORDER_TOLERANCE, "", reason, "converged")
    return {
        "links": counts,
        "max_error_vs_arc_m": errors,
        "max_error_vs_chain_m": chain_errors,
        "observed_orders": orders,
        **verdict([check]),
    }


def attempt_convergence(arm: Arm, bends: Array, track: Track) -> dict[str, Any]:
    """Do as `convergence`; where an arm has no rest pose, that is the verdict, with its `reason`."""
    try:
        return convergence(arm, bends, track)
    except (ConvergenceError, DivergenceError) as error:
        judged = {"verdict": NO_REST, "converged": False, "reason": str(error), "checks": []}
        return {"links": refinements(arm.links)} | judged

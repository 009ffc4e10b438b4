"""How the discretisation error falls with the number of links: with the second power, or something is wrong."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field, replace

from contarm_sim.display import Shown
from contarm_sim.errors import DivergenceError, EquilibriumError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.section import MAX_LINKS
from contarm_sim.results.document import INLINE
from contarm_sim.studies.at_rest import NO_REST, at_rest
from contarm_sim.studies.progress import Track, quietly
from contarm_sim.studies.scenarios import Scenario
from contarm_sim.studies.verdict import ORDER_TOLERANCE, Check, Verdict, at_most, verdict


@dataclass(frozen=True, repr=False)
class Convergence(Shown):
    """The largest tip errors of arms of three link counts, without gravity.

    Attributes:
        links: the counts, of all sections together.
        max_error_vs_arc_m, max_error_vs_chain_m: largest errors [m], one a count.
        observed_orders: of the error against the arc, one a step from one count to the next.
        judged: whether the last order is 2.
    """

    links: list[int]
    max_error_vs_arc_m: list[float]
    max_error_vs_chain_m: list[float]
    observed_orders: list[float]
    judged: Verdict = field(metadata=INLINE)

    @property
    def verdict(self) -> str:
        """Pass or fail."""
        return self.judged.verdict


@dataclass(frozen=True, kw_only=True)
class NoConvergence:
    """Link counts of which one has no rest pose somewhere; `reason` says where, and why."""

    links: list[int]
    verdict: str = NO_REST
    converged: bool = False
    reason: str
    checks: tuple[Check, ...] = ()


def refinements(links: int) -> list[int]:
    """Return three link counts, each twice the one before, that hold or surround `links`."""
    if links > 96:
        return [links // 4, links // 2, links]
    return [links // 2, links, 2 * links] if links >= 12 else [links, 2 * links, 4 * links]


def refined(arm: Arm) -> list[Arm]:
    """Return three arms of such link counts; the sections of several are refined alike."""
    if len(arm.sections) == 1:
        return [replace(arm, links=links) for links in refinements(arm.links)]
    links = [section.links for section in arm.sections]
    halves = min(links) >= 12 and all(count % 2 == 0 for count in links)
    shares: tuple[float, ...] = (0.5, 1, 2) if halves and 2 * sum(links) <= MAX_LINKS else (1, 2, 4)
    if max(shares) * sum(links) > MAX_LINKS:
        shares = (0.25, 0.5, 1)
        if any(count % 4 for count in links):
            links = [max(4, 4 * (count // 4)) for count in links]
    made = [tuple(replace(s, links=round(share * n)) for s, n in zip(arm.sections, links, strict=True))
            for share in shares]  # fmt: skip
    return [replace(arm, sections=sections) for sections in made]


def convergence(arm: Arm, bends: Array, track: Track = quietly) -> Convergence:
    """Return the largest tip error against the arc over bends [rad], shape (T, 2 S), for three link counts.

    Raises:
        EquilibriumError, DivergenceError: one of the arms has no such rest pose.
    """
    counts: list[int] = []
    errors: list[float] = []
    chain_errors: list[float] = []
    for finer in refined(arm.unloaded):
        scenario = Scenario(f"{finer.links} links", "no gravity", finer, "servo", None)
        found = at_rest(scenario, bends, track)
        counts.append(finer.links)
        errors.append(found.errors.tip_error.max_m)
        chain_errors.append(found.chain_error.max_m)
    pairs = zip(itertools.pairwise(errors), itertools.pairwise(counts), strict=True)
    orders = [math.log(e0 / e1) / math.log(n1 / n0) for (e0, e1), (n0, n1) in pairs]
    reason = "the chain does not approach the arc as straight links do"
    off = abs(orders[-1] - 2)
    check = at_most("order of convergence, off 2 by", off, ORDER_TOLERANCE, "", reason, "converged")
    return Convergence(counts, errors, chain_errors, orders, verdict([check]))


def attempt_convergence(arm: Arm, bends: Array, track: Track = quietly) -> Convergence | NoConvergence:
    """Do as `convergence`; where an arm has no rest pose, return that."""
    try:
        return convergence(arm, bends, track)
    except (EquilibriumError, DivergenceError) as error:
        return NoConvergence(links=[finer.links for finer in refined(arm)], reason=str(error))

"""What became of the cases of an uncertain arm: how many have a result, percentiles, causes, a table."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.sweeps.causes import Causes, causes
from contarm_sim.sweeps.statuses import OK
from contarm_sim.sweeps.uncertain import Uncertain, read_uncertain

PERCENTS = (5, 50, 95)
"""Percentiles that are given of everything."""


@dataclass(frozen=True, eq=False, repr=False)
class Outcomes:
    """What became of the cases that were run, of those that were asked for.

    Attributes:
        uncertain: what was drawn.
        status: of each case that was run, see `sweeps.statuses`.
        error: why there is no result, or "".
        interrupted: whether Ctrl-C left cases out.
    """

    uncertain: Uncertain
    status: tuple[str, ...]
    error: tuple[str, ...]
    interrupted: bool

    def __repr__(self) -> str:
        vary = ", ".join(self.uncertain.names)
        return (
            f"{type(self).__name__}({int(self.good.sum())} of {self.uncertain.cases} sampled arms; uncertain: {vary})"
        )

    @property
    def good(self) -> NDArray[np.bool_]:
        """Whether a case has a result, shape (cases run,)."""
        return np.array([each == OK for each in self.status], dtype=bool)

    @property
    def failed(self) -> dict[str, int]:
        """How many cases have no result, by status."""
        return dict(Counter(each for each in self.status if each != OK))

    def parameters(self) -> dict[str, Any]:
        """Return what was drawn of each parameter: unit, the nominal value, percentiles."""
        told, uncertain = {}, self.uncertain
        for name, one in uncertain.parameters.items():
            drawn = np.percentile(np.array(uncertain.values[name], dtype=float), PERCENTS).tolist()
            told[name] = {"unit": one.unit, "nominal": one.value(uncertain.arm)} | percentiles(drawn)
        return told

    def causes_of(self, values: Array) -> Causes:
        """Return what causes the spread of a quantity of the cases that were run, NaN where there is none."""
        places, normal = self.uncertain.standard
        return causes(places[: len(self.status)], normal, values, self.uncertain.seed)

    def about(self) -> dict[str, Any]:
        """Return what a document says of the cases."""
        uncertain = self.uncertain
        return {
            "cases": uncertain.cases, "run": len(self.status), "with_result": int(self.good.sum()),
            "failed": self.failed, "interrupted": self.interrupted, "seed": uncertain.seed,
            "parameters": self.parameters(),
        }  # fmt: skip


def percentiles(values: Any) -> dict[str, Any]:
    """Return values by the names of their percentiles: p5, p50, p95."""
    return {f"p{percent}": value for percent, value in zip(PERCENTS, values, strict=True)}


def causes_document(found: Causes, names: tuple[str, ...]) -> dict[str, Any]:
    """Return causes as plain values, by parameter."""
    about: dict[str, Any] = {"explained": found.explained if np.isfinite(found.explained) else None}
    if found.reason:
        return about | {"reason": found.reason}
    rows = zip(names, found.first, found.first_interval, found.total, found.total_interval, strict=True)
    by_name = {
        name: {"first": float(first), "first_95": one.tolist(), "total": float(total), "total_95": two.tolist()}
        for name, first, one, total, two in rows
    }
    return about | {"degree": found.degree, "terms": found.terms, "parameters": by_name}


def uncertain_of(arm: Arm, given: Any) -> Uncertain:
    """Return the uncertain parameters of an arm: themselves, or what a TOML file or mapping says.

    Raises:
        InputError: they are of another arm, or see `read_uncertain`.
    """
    uncertain = given if isinstance(given, Uncertain) else read_uncertain(given, arm)
    if uncertain.arm != arm:
        raise InputError("uncertain", "of another arm", "of the arm that is given")
    return uncertain

"""What a sweep is: read from TOML or a dict, checked before anything runs, and written back in full."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_to_dict
from contarm_sim.sweeps.designs import Design, Values, count_of, grids, of_grid, of_indices, of_points, points
from contarm_sim.sweeps.distributions import Normal, Range, Varied
from contarm_sim.sweeps.distributions import Values as Listed
from contarm_sim.sweeps.names import Parameter, Run, known_names

FORMAT = 1
"""Number of the form that sweeps are kept in: another one cannot be resumed."""

_AT_ONCE = 2**16
"""Cases that are looked at together."""


@dataclass(frozen=True, eq=False)
class Spec:
    """A sweep as it is run. `sweeps.read` makes one, and checks it.

    Attributes:
        name: what it is called; no part of what is computed.
        run: what a case does.
        arm: whose parameters change.
        design: which cases there are.
        drawn: cases that a design draws; points A, of `sobol-indices`; nothing to a grid.
        seed: of what is drawn.
        ask: names of the quantities.
        fixed: values of parameters that all cases share, SI units.
        vary: what the parameters that vary may be.
        backend: what motions are stepped by.
    """

    name: str
    run: Run
    arm: Arm
    design: Design
    drawn: int
    seed: int
    ask: tuple[str, ...]
    fixed: Mapping[str, Any]
    vary: Mapping[str, Varied]
    backend: str = "cpu"

    @cached_property
    def known(self) -> dict[str, Parameter]:
        """What cases may differ in, by name."""
        return known_names(self.arm, self.run)

    @cached_property
    def tried(self) -> dict[str, list[Any]]:
        """The values that a grid tries, by name; nothing for other designs."""
        return grids(self.vary, self.known) if self.design == "grid" else {}

    @cached_property
    def cases(self) -> int:
        """How many cases there are."""
        return count_of(self.design, self.drawn, self.tried, len(self.vary))

    def values(self, first: int, last: int) -> list[Values]:
        """Return the parameters that vary in cases first to last - 1."""
        if self.design == "grid":
            return of_grid(self.tried, first, last)
        if self.design == "sobol-indices":
            return of_indices(self.vary, self.known, self.drawn, self.seed, first, last)
        shares = points(self.design, self.drawn, len(self.vary), self.seed, first, last)
        return of_points(self.vary, self.known, shares)

    def extremes(self) -> dict[str, list[Any]]:
        """Return the least and the largest value of each parameter in all cases of a design that is drawn."""
        size = len(self.vary)
        columns = 2 * size if self.design == "sobol-indices" else size
        low, high = np.ones(columns), np.zeros(columns)
        for first in range(0, self.drawn, _AT_ONCE):
            found = points(self.design, self.drawn, columns, self.seed, first, min(first + _AT_ONCE, self.drawn))
            low, high = np.minimum(low, found.min(axis=0)), np.maximum(high, found.max(axis=0))
        low, high = low.reshape(-1, size).min(axis=0), high.reshape(-1, size).max(axis=0)
        return {name: one.at(np.array([low[k], high[k]])) for k, (name, one) in enumerate(self.vary.items())}

    def parameters(self) -> Iterator[Parameter]:
        """Yield what varies."""
        return (self.known[name] for name in self.vary)

    def to_dict(self) -> dict[str, Any]:
        """Return the sweep as plain values, the arm in full, numbers in SI units: `sweeps.read` reads them back."""
        drawn = {"grid": {}, "sobol-indices": {"points": self.drawn}}.get(self.design, {"cases": self.drawn})
        made: dict[str, Any] = {"run": self.run, "design": self.design, **drawn}
        made |= {} if self.design == "grid" else {"seed": self.seed}
        made |= {"backend": self.backend} if self.run == "motion" else {}
        made |= {"ask": list(self.ask), "arm": arm_to_dict(self.arm)}
        made |= {"fixed": {name: _plain(value) for name, value in self.fixed.items()}} if self.fixed else {}
        return made | {"vary": {name: _said(varied) for name, varied in self.vary.items()}}

    @cached_property
    def key(self) -> str:
        """What two sweeps of the same cases have in common, 64 hexadecimal digits."""
        said = json.dumps([FORMAT, self.to_dict()])
        return hashlib.sha256(said.encode()).hexdigest()


def _plain(value: Any) -> Any:
    return [_plain(each) for each in value] if isinstance(value, tuple) else value


def _said(varied: Varied) -> Any:
    """Return what a parameter may be as TOML has it."""
    if isinstance(varied, Listed):
        return [_plain(value) for value in varied.values]
    if isinstance(varied, Range):
        count = {} if varied.count is None else {"count": varied.count}
        return {"from": varied.low, "to": varied.high, **count, "scale": "log" if varied.log else "linear"}
    assert isinstance(varied, Normal)
    limits = {name: value for name, value in (("least", varied.least), ("most", varied.most)) if math.isfinite(value)}
    kind = "lognormal" if varied.log else "normal"
    return {"distribution": kind, "mean": varied.mean, "std": varied.std, **limits}

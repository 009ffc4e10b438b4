"""A sweep's table as its report needs it: one quantity, the parameters that vary, what failed, what was largest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.named import find, with_parameters
from contarm_sim.results.document import document
from contarm_sim.sweeps.distributions import Normal, Range
from contarm_sim.sweeps.effects import SURE, effect
from contarm_sim.sweeps.sensitivity import Indices, indices_of
from contarm_sim.sweeps.statuses import OK
from contarm_sim.sweeps.table import Sweep
from contarm_sim.sweeps.validity import Validity, chart_of
from contarm_sim.view.report.sweeps.columns import Column, by_effect, in_digits

FIRST = ("tip_error_max_percent", "tip_error_percent", "tip_error_max", "tip_error")
"""Quantities that are reported if nothing else is said: the first that was asked for."""

_LABELS = ("own_weight_over_stiffness", "weight_over_stiffness", "payload_over_mass")
"""Quantities that say which case it is."""

EXTREMES = 5
"""Cases of the table of largest values."""


@dataclass(frozen=True, eq=False)
class Found:
    """What a report says of a sweep.

    Attributes:
        sweep: the table.
        quantity: the name of what is reported.
    """

    sweep: Sweep
    quantity: str

    @cached_property
    def value(self) -> Column:
        """The quantity of all cases that are done, NaN where there is none, or of a pose that would not stay."""
        return replace(self._column(self.quantity), values=self.sweep.values(self.quantity))

    @cached_property
    def columns(self) -> list[Column]:
        """The parameters that vary."""
        return [self._column(name) for name in self.sweep.spec.vary]

    @cached_property
    def cases(self) -> NDArray[Any]:
        """The numbers of the cases."""
        return np.asarray(self.sweep.column("case"))

    @cached_property
    def status(self) -> NDArray[Any]:
        """What became of each case."""
        return np.asarray(self.sweep.column("status"))

    @property
    def failed(self) -> NDArray[Any]:
        """Which cases failed, shape (K,)."""
        return np.asarray(self.status != OK)

    @property
    def grid(self) -> bool:
        """Whether others can stand at levels."""
        return self.sweep.spec.design == "grid"

    @cached_property
    def known(self) -> NDArray[Any]:
        """The values that there are, in the unit that people read."""
        shown = self.value.shown
        return np.asarray(shown[np.isfinite(shown)])

    @cached_property
    def chart(self) -> Validity | None:
        """The validity chart, of a sweep that has one."""
        return chart_of(self.sweep)

    @cached_property
    def _indices(self) -> Indices | str:
        try:
            return indices_of(self.sweep, self.quantity)
        except InputError as error:
            return str(error)

    @property
    def indices(self) -> Indices | None:
        """Sobol's indices, where there are any."""
        return None if isinstance(self._indices, str) else self._indices

    @property
    def no_indices(self) -> str:
        """Why there are no Sobol's indices, or ""."""
        return self._indices if isinstance(self._indices, str) else ""

    @cached_property
    def ranked(self) -> list[str]:
        """Names of the parameters, that of the largest effect first."""
        if self.indices is not None:
            return [self.indices.names[k] for k in np.argsort(-self.indices.total)]
        return [column.name for column in by_effect(self.columns, self._graded)]

    @property
    def matters(self) -> str | None:
        """The parameter of the largest effect; None where there are not two, or it may be chance or another's."""
        if len(self.ranked) < 2:
            return None
        first = self.ranked[0]
        if self.indices is not None:
            low, high = self.indices.total_interval[:, np.argsort(-self.indices.total)[:2]]
            sure = low[0] > max(high[1], 0.0)
        else:
            column = next(column for column in self.columns if column.name == first)
            sure = effect(column.values, self._graded, column.drawn).chance * len(self.ranked) < SURE
        return first if sure else None

    @property
    def _graded(self) -> Array:
        """The quantity as effects are found of it: its logarithm where that is drawn."""
        return np.log(self.value.shown) if self.value.log else self.value.shown

    @property
    def arm(self) -> Arm:
        """The arm whose parameters change."""
        spec = self.sweep.spec
        return with_parameters(spec.arm, {name: v for name, v in spec.fixed.items() if spec.known[name].of_arm})

    def extremes(self) -> list[tuple[str, int]]:
        """Return which cases have the largest values, and which the least: words and rows of the table."""
        shown = self.value.shown
        order = [int(row) for row in np.argsort(-shown, kind="stable") if np.isfinite(shown[row])]
        most = order[:EXTREMES]
        least = [row for row in order[::-1][:EXTREMES] if row not in most]
        return [("largest", row) for row in most] + [("least", row) for row in least[::-1]]

    def told(self, row: int) -> dict[str, Any]:
        """Return the number, the parameters and the quantity of a case."""
        said = {column.name: column.values[row] for column in self.columns}
        return {"case": int(self.cases[row]), **said, self.quantity: self.value.values[row]}

    def why(self) -> list[tuple[str, int, str]]:
        """Return each status of cases that failed, how many have it, and what the first of them says."""
        import pyarrow.dataset as ds

        lost = self.sweep.dataset.to_table(columns=["status", "error"], filter=ds.field("status") != OK)
        said: dict[str, str] = {}
        for status, error in zip(lost["status"].to_pylist(), lost["error"].to_pylist(), strict=True):
            said.setdefault(status, error or "")
        return [(status, count, said[status]) for status, count in self.sweep.counts.items() if status != OK]

    def document(self) -> dict[str, Any]:
        """Return the report in numbers, SI units."""
        spec, (_, *middle) = self.sweep.spec, self.sweep.middle(self.quantity)
        made: dict[str, Any] = {
            "sweep": spec.to_dict(),
            "folder": str(self.sweep.folder),
            "cases": spec.cases,
            "done": len(self.sweep),
            "status": dict(self.sweep.counts),
            "quantity": {"name": self.quantity, "unit": self.value.unit}
            | dict(zip(("least", "median", "largest"), middle, strict=False)),
            "by_effect": self.ranked,
            "extremes": [{"which": which, **document(self.told(row))} for which, row in self.extremes()],
        }
        if self.indices is not None:
            made["sobol_indices"] = document(self.indices)
        if self.chart is not None:
            made["validity"] = self._validity(self.chart)
        return made

    def _validity(self, chart: Validity) -> dict[str, Any]:
        within = [
            {
                "stance": stance.meaning,
                "within_percent": bound,
                "own_weight_over_stiffness": chart.weight_within(bound, k),
            }
            for k, stance in enumerate(chart.stances)
            for bound in chart.bounds
        ]
        return {"max_bend_deg": chart.max_bend_deg, "links": chart.usual_links, "largest_weights": within}

    def _column(self, name: str) -> Column:
        values = self.sweep.column(name)
        if values.ndim == 2:
            values = np.array([f"({', '.join(in_digits(x) for x in row)})" for row in values], dtype=object)
        elif values.dtype == bool:
            values = values.astype(float)
        varied = self.sweep.spec.vary.get(name)
        spread = varied if isinstance(varied, Range | Normal) else None
        log = None if spread is None else spread.log
        return Column(name, self.sweep.unit(name), values, log, drawn=spread is not None and not self.grid)


def found_of(sweep: Sweep, quantity: str | None = None) -> Found:
    """Return what a report says of a sweep.

    Args:
        quantity: the name of one that was asked for; default the largest tip error, or else the first that has values.

    Raises:
        InputError: no case is done yet, or no such quantity was asked for.
    """
    asked = sweep.spec.ask
    if len(sweep) == 0:
        raise InputError("sweep", str(sweep.folder), "a sweep with some case done; none is yet")
    if quantity is not None:
        find(quantity, {name: name for name in asked}, "--quantity", "quantity")
        return Found(sweep, quantity)
    first = [name for name in FIRST if name in asked] or [name for name in asked if name not in _LABELS] or list(asked)
    first += [name for name in asked if name not in first]
    return Found(sweep, next((name for name in first if sweep.middle(name)[0]), first[0]))

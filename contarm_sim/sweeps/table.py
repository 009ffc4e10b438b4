"""A sweep that was run, or is being run: its table, column by column."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.inputs import as_path
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.named import find
from contarm_sim.sweeps.quantities import QUANTITIES
from contarm_sim.sweeps.spec import Spec
from contarm_sim.sweeps.statuses import OK, UNSTABLE
from contarm_sim.sweeps.store import kept, parts_of, require_pyarrow, schema

LACKING = {
    "feasible": "need more than the muscles have",
    "explained": "are not explained: too fast, lengths not reached, or too far from the model",
}
"""Quantities that are true or false, and what is said where they are false."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """A sweep's folder, read.

    Attributes:
        folder: where it is.
        spec: what was asked.
        made: versions that it is made with, by name.
    """

    folder: Path
    spec: Spec
    made: dict[str, str]

    def __repr__(self) -> str:
        counts = ", ".join(f"{count} {status}" for status, count in self.counts.items())
        return f"Sweep({self.spec.name}: {self.spec.cases} cases, {counts or 'none done'})"

    def __len__(self) -> int:
        return sum(self.counts.values())

    @cached_property
    def dataset(self) -> Any:
        """The table as a `pyarrow.dataset`, which reads from the disk what is asked of it."""
        import pyarrow.dataset as ds

        return ds.dataset([str(path) for path in parts_of(self.folder)], schema=schema(self.spec), format="parquet")

    @cached_property
    def table(self) -> Any:
        """The table in memory, a `pyarrow.Table`, one row a case that is done, in order."""
        return self.dataset.to_table()

    @cached_property
    def counts(self) -> dict[str, int]:
        """How many cases are of each status, `ok` first."""
        found: Counter[str] = Counter()
        for batch in self.dataset.to_batches(columns=["status"]):
            for each in batch.column(0).value_counts().to_pylist():
                found[each["values"]] += each["counts"]
        return dict(sorted(found.items(), key=lambda item: (item[0] != OK, -item[1], item[0])))

    @cached_property
    def short(self) -> dict[str, int]:
        """How many cases that went well are not `feasible`, or not `explained`; without those that none is."""
        good = self.column("status") == OK
        counts = {name: int((good & (self.column(name) == 0)).sum()) for name in LACKING if name in self.spec.ask}
        return {name: count for name, count in counts.items() if count}

    def column(self, name: str) -> Any:
        """Return a column as a NumPy array, shape (cases,), of a vector (cases, size); NaN where there is no value.

        Raises:
            InputError: there is none of this name; says the nearest.
        """
        find(name, {one: one for one in self.dataset.schema.names}, what="column")
        column = self.dataset.to_table(columns=[name]).column(0)
        size = getattr(column.type, "list_size", None)
        if size is not None:
            return np.array(column.to_pylist(), dtype=float).reshape(-1, size)
        if column.type in _numbers():
            return column.to_numpy() if not column.null_count else column.cast("float64").to_numpy()
        return np.array(column.to_pylist(), dtype=object)

    def values(self, name: str) -> Array:
        """Return a quantity in numbers, shape (cases,); NaN where there is none, and of poses that would not stay.

        What the arm alone tells, and what is true or false, is told of these too.
        """
        one, values = QUANTITIES[self.spec.run][name], np.asarray(self.column(name), dtype=float)
        return np.where((self.column("status") != UNSTABLE) | one.of_arm | (one.kind == "truth"), values, np.nan)

    def middle(self, name: str) -> list[Any]:
        """Return how many cases have a value of a quantity and, where any does, the least, the median, the largest."""
        values = self.values(name)
        values = values[np.isfinite(values)]
        return [len(values), *(np.percentile(values, (0, 50, 100)).tolist() if len(values) else [])]

    def unit(self, name: str) -> str:
        """Return the unit of a column, "-" where it has none."""
        said = self.dataset.schema.field(name).metadata or {}
        return str(said.get(b"unit", b"-").decode())


def _numbers() -> tuple[Any, ...]:
    import pyarrow as pa

    return pa.float64(), pa.int64(), pa.bool_()


def load(folder: str | PathLike[str]) -> Sweep:
    """Return the sweep of a folder, done or not.

    Raises:
        InputError: there is none.
        MissingError: pyarrow is not installed.
    """
    require_pyarrow()
    path = as_path("sweep", folder, "a sweep's folder")
    if not path.is_dir():
        raise InputError("sweep", repr(str(path)), "a folder that contarm sweep left")
    return Sweep(path, *kept(path))

"""The cases of an uncertain arm as a table: Parquet, or .npz where pyarrow is not installed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.files import appearing
from contarm_sim.sweeps.spread_of_motion import UncertainMotion
from contarm_sim.sweeps.spread_of_pose import UncertainPose

TABLES = ("cases.parquet", "cases.npz")
"""Files that hold the cases, the one or the other."""


def _role(name: str, found: UncertainMotion | UncertainPose) -> str:
    return "parameter" if name in found.uncertain.names else "case" if name == "case" else "quantity"


def write_cases(folder: Path, found: UncertainMotion | UncertainPose) -> str:
    """Write cases.parquet, one row a case: parameters, quantities, status and error text; return the file's name.

    Units are in the metadata of the columns (key `unit`), as of sweeps. Without pyarrow, cases.npz has these
    columns, and their units as an array `units` beside `columns`.
    """
    run, uncertain = len(found.status), found.uncertain
    columns: dict[str, tuple[str, Any]] = {"case": ("-", np.arange(run))}
    for name, one in uncertain.parameters.items():
        columns[name] = (one.unit, np.array(uncertain.values[name][:run], dtype=float))
    columns |= found.columns()
    texts = {"status": found.status, "error": found.error}
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        about = {"columns": list(columns), "units": [unit for unit, _ in columns.values()]}
        arrays: dict[str, Any] = {name: np.asarray(values) for name, (_, values) in columns.items()}
        arrays |= {name: np.array(words) for name, words in (texts | about).items()}
        with appearing(folder / "cases.npz") as scratch, scratch.open("wb") as file:
            np.savez_compressed(file, **arrays)
        return "cases.npz"
    fields = [
        pyarrow.field(
            name,
            pyarrow.from_numpy_dtype(np.asarray(values).dtype),
            metadata={"role": _role(name, found), "unit": unit},
        )
        for name, (unit, values) in columns.items()
    ]
    fields += [pyarrow.field(name, pyarrow.string()) for name in texts]
    data = [pyarrow.array(np.asarray(values)) for _, values in columns.values()]
    data += [pyarrow.array(list(words), pyarrow.string()) for words in texts.values()]
    with appearing(folder / "cases.parquet") as scratch:
        parquet.write_table(pyarrow.Table.from_arrays(data, schema=pyarrow.schema(fields)), scratch)
    return "cases.parquet"

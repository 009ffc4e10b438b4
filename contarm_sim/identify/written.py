"""Commands as a rig's own files have them: names of columns, unit and sign, as in a recording; SI units for a rig."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.identify.data_files import read_columns
from contarm_sim.identify.rig import Rig
from contarm_sim.identify.rig_file import read_toml
from contarm_sim.identify.spec_keys import in_si
from contarm_sim.inputs import as_path
from contarm_sim.kinematics.arrays import Array

BLOCK = "block"
"""Column that names the pattern of each row."""

_SI = {"windings": "m", "tensions": "N", "pressures": "Pa"}


@dataclass(frozen=True)
class Written:
    """How commands of C channels are written.

    Attributes:
        columns: names, C of them.
        unit: of the numbers, as it is said.
        worth: what one unit is in SI units; negative where pulling is.
    """

    columns: tuple[str, ...]
    unit: str
    worth: float

    def numbers(self, commands: Array) -> Array:
        """Return commands in SI units, shape (T, C), as they are written."""
        return np.asarray(commands / self.worth) + 0.0

    def text(self, commands: Array, blocks: NDArray[np.str_]) -> str:
        """Return the CSV of commands in SI units, shape (T, C), with the pattern of each."""
        out = io.StringIO()
        rows = csv.writer(out, lineterminator="\n")
        rows.writerow([BLOCK, *self.columns])
        for block, row in zip(blocks.tolist(), self.numbers(commands).tolist(), strict=True):
            rows.writerow([block, *(f"{x:.9g}" for x in row)])
        return out.getvalue()

    def read(self, path: str | Path) -> tuple[Array, list[str] | None]:
        """Return commands of a CSV in SI units, shape (T, C), and the pattern of each row, if it has a column for it.

        Raises:
            InputError: a file that cannot be read, or a column that is missing or has no number.
        """
        found = read_columns(as_path("candidates", path, "a CSV file"))
        names = found.named(list(self.columns), "candidates")
        values = np.stack([found.numbers(name, "candidates") for name in names], axis=1)
        if not np.isfinite(values).all():
            row = int(np.argwhere(~np.isfinite(values))[0][0])
            raise InputError("candidates", f"no number in row {row + 1}", "a number in each column", str(path))
        return self.worth * values, found.texts(BLOCK, "candidates") if BLOCK in found.cells else None


def written_of(rig: Rig, recording: str | Path | None = None) -> Written:
    """Return how a rig's commands are written: as in a recording's TOML, or in SI units without one.

    Raises:
        InputError: a rig that nothing drives.
    """
    drive, count = rig.actuation.drive, len(rig.actuation.gains)
    if drive == "none":
        raise InputError("actuation.drive", "'none'", "a rig whose muscles are driven: there is nothing to command")
    plain = all(gain == 1 for gain in rig.actuation.gains)
    if recording is None:
        names = tuple(f"command_{k + 1}" for k in range(count))
        return Written(names, _SI[drive] if plain else "SI", 1.0)
    said = read_toml(as_path("recording", recording, "a TOML file"), 'data = "poses.csv"')["commands"]
    names, unit = said["columns"], said.get("unit")
    columns = tuple(names) if isinstance(names, list) else tuple(f"{names}.{k + 1}" for k in range(count))
    worth = 1.0
    if unit not in (None, "SI"):
        worth = float(in_si(np.ones(1), unit, ("m", "rad", "N", "Pa", "-"), "commands.unit")[0][0])
    return Written(
        columns,
        _SI[drive] if unit in (None, "SI") and plain else unit or "SI",
        -worth if said.get("pull") == "negative" else worth,
    )

"""contacts.csv: one row a contact, and the columns of samples.csv that tell of contact; units in the header."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import names
from contarm_sim.results.trajectory import Trajectory

_NUMBERS = (
    *(f"{name}_{axis}_{unit}" for name, unit in (("point", "m"), ("force", "n")) for axis in "xyz"),
    "force_n", "normal_force_n", "friction_force_n", *(f"normal_{axis}" for axis in "xyz"), "depth_m",
)  # fmt: skip


def write_contacts(path: Path, samples: Trajectory) -> None:
    """Write all contacts of a motion: when, which link (its number from the base, and its name), what, where, how hard.

    Places and forces are in the base frame; forces are those on the arm.
    """
    found, links = samples.contacts, names.stations(samples.arm)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", "sample", "link", "link_name", "object", *_NUMBERS])
        if found is None:
            return
        table = np.column_stack(
            [found.point, found.force, np.linalg.norm(found.force, axis=1), found.normal_force, found.friction_force,
             found.normal, found.depth]
        )  # fmt: skip
        for sample, link, partner, numbers in zip(found.sample, found.station, found.partner, table, strict=True):
            row: list[Any] = [f"{samples.time[sample]:.9g}", sample, link, links[link], found.names[partner]]
            writer.writerow([*row, *(f"{x + 0.0:.9g}" for x in numbers)])


def columns(samples: Trajectory) -> dict[str, Array]:
    """Return the columns of samples.csv of what is touched and of where free objects are, shape (T,) each."""
    found, count = samples.contacts, len(samples)
    made: dict[str, Array] = {}
    if found is not None:
        made["contact_force_n"] = found.total(count)
        made["contacts"] = np.bincount(found.sample, minlength=count).astype(float)
        made["contact_depth_m"] = found.deepest(count)
    if samples.objects is not None:
        for number, name in enumerate(samples.arm.world.movable):
            parts = (*(f"{axis}_m" for axis in "xyz"), *(f"q{part}" for part in "wxyz"))
            made |= {f"{name}_{part}": samples.objects[:, number, i] for i, part in enumerate(parts)}
    return made

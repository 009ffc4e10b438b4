"""samples.csv: one row a sample, target, analytic, chain-form and simulated tip side by side, units in the header."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from contarm_sim.mjcf import names
from contarm_sim.results.compare import Comparison
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.report.contacts_csv import columns

_VECTORS = ("target", "analytic_tip", "chain_tip", "followed_tip", "simulated_tip")


def write_samples(path: Path, groups: dict[str, tuple[Trajectory, Comparison]], setpoint: str = "setpoint_m") -> None:
    """Write all samples of one or more named groups (scenarios) to a CSV file; `setpoint` names that column.

    Of several sections, bends, muscles and the parts of the error that are one section's begin with `section_2_`.
    """
    arm = next(iter(groups.values()))[0].arm
    sections = [names.of_section(arm, number) for number in range(len(arm.sections))]
    header = ["scenario", "time_s", *(f"{section}bend_{axis}_rad" for section in sections for axis in "xy")]
    header += [f"{name}_{axis}_m" for name in _VECTORS for axis in "xyz"]
    distances = ["target_error", "miss", "tip_error", "discretisation", "servo", "shape", "backbone_error"]
    distances += ["contact"] if all(each.contact is not None for _, each in groups.values()) else []
    header += [*(f"{name}_m" for name in distances), "orientation_error_deg"]
    whats = (setpoint, "length_m", "tension_n", "pressure_pa")
    header += [f"{muscle}_{what}" for what in whats for muscle in names.muscles(arm)]
    parts = ("discretisation", "servo", "shape") if len(sections) > 1 else ()
    header += [f"{section}{part}_m" for part in parts for section in sections]
    header += columns(next(iter(groups.values()))[0])
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        for name, (samples, comparison) in groups.items():
            table = np.column_stack(
                [
                    samples.time,
                    samples.bend,
                    samples.target,
                    comparison.analytic_tip,
                    comparison.chain_tip,
                    comparison.followed_tip,
                    comparison.simulated_tip,
                    *(getattr(comparison, distance) for distance in distances),
                    np.degrees(comparison.orientation_error),
                    samples.setpoint,
                    samples.muscle_lengths,
                    samples.muscle_tensions,
                    samples.pressure,
                    *(getattr(comparison, f"section_{part}") for part in parts),
                    *columns(samples).values(),
                ]
            )
            writer.writerows([name, *(f"{x:.9g}" for x in row)] for row in table)

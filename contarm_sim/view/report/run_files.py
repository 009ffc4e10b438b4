"""The files that a motion leaves, by which its folder can be opened, moved and drawn again."""

from __future__ import annotations

from pathlib import Path

from contarm_sim.mjcf import arm_spec, exact_xml
from contarm_sim.model.arm_file import arm_to_toml
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.report.contacts_csv import write_contacts


def write_run(folder: Path, run: Trajectory) -> None:
    """Write trajectory.npz, arm.toml, arm.xml with its meshes, and contacts.csv where the arm can touch something."""
    run.save(folder / "trajectory.npz")
    if run.contacts is not None:
        write_contacts(folder / "contacts.csv", run)
    spec = arm_spec(run.arm, "pressures" if run.actuation == "pressures" else "lengths")
    (folder / "arm.xml").write_text(exact_xml(spec, folder))
    (folder / "arm.toml").write_text(arm_to_toml(run.arm, beside=True))

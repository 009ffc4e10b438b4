"""`contarm compare-controllers`: the spiral under every controller, with and without gravity and payload."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.options import Command, arm_options, json_option, out_option
from contarm_sim.model.arm import Arm


@click.command(cls=Command, name="compare-controllers")
@click.option("--duration", type=float, default=10.0, show_default=True, metavar="S", help="Time for the spiral [s].")
@out_option("runs/compare-controllers-<time>")
@json_option
@arm_options
def compare_controllers(arm: Arm, duration: float, out: str | None, as_json: bool) -> int:
    """Run the spiral with each controller, free, hanging and hanging with a payload, and print one table.

    Errors are from target to simulated tip, after the first second (or half of a
    shorter path). `along` is the part along the surface that the
    tip can reach under that load; what lies across it no lengths can remove, for it is not the dome of the targets.
    Exit code 1 if a controller could not follow the spiral; a line says why.
    """
    from contarm_sim.cli.terminal import command_line, say, table, track
    from contarm_sim.model.arm_file import arm_to_dict
    from contarm_sim.studies.controllers import compare_all
    from contarm_sim.view.report.output import OutputFolder, check_output, default_folder, to_json, versions

    target = Path(out) if out is not None else default_folder("compare-controllers")
    check_output(target)
    rows = compare_all(arm, duration, track)
    summary = {"rows": rows, "duration": duration, "arm": arm_to_dict(arm)}
    summary |= {"versions": versions(), "command": command_line()}
    with OutputFolder(target) as opened:
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
    if as_json:
        click.echo(to_json(summary))
    else:
        columns = ["load", "controller", "rms [%]", "max [%]", "along [%]", "lag [ms]", "tension [N]"]
        columns += ["needs [kPa]", "pushes [%]", "effort [N]"]
        table(f"spiral, {duration:g} s; tip errors in % of backbone length", columns, [_cells(row) for row in rows])
        for row in rows:
            if "failed" in row:
                click.echo(f"{row['load']}, {row['controller']}: failed: {row['failed']}")
    say(f"written: {opened.target}")
    return 1 if any("failed" in row for row in rows) else 0


def _cells(row: dict[str, Any]) -> list[str]:
    head = [row["load"], row["controller"]]
    if "failed" in row:
        return [*head, "failed", *[""] * 7]
    pressure = row["peak_pressure_pa"]
    return [
        *head,
        f"{row['tip_rms_percent']:.3f}",
        f"{row['tip_max_percent']:.3f}",
        f"{row['along_rms_percent']:.3f}",
        f"{1e3 * row['lag_s'] + 0.0:.1f}",
        f"{row['peak_tension_n']:.1f}",
        "more than any" if pressure is None else f"{pressure / 1e3:.0f}",
        f"{100 * row['push_fraction']:.3g}",
        f"{row['effort_n']:.1f}",
    ]

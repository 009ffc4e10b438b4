"""`contarm compare-controllers`: the spiral under every controller, with and without gravity and payload."""

from __future__ import annotations

from pathlib import Path

import click

from contarm_sim import studies
from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import TIME, Command, arm_options, json_option, out_option
from contarm_sim.model.arm import Arm
from contarm_sim.view.prints import Prints


@click.command(cls=Command, name="compare-controllers")
@click.option("--duration", type=TIME, default=10.0, show_default=True, metavar="S", help="Time for the spiral [s].")
@out_option("runs/compare-controllers-<time>")
@figure_options()
@json_option
@arm_options
def compare_controllers(arm: Arm, duration: float, out: str | None, prints: Prints, as_json: bool) -> int:
    """Run the spiral with each controller, free, hanging and hanging with a payload, print one table, and draw it.

    Errors are from target to simulated tip, after the first second (or half of a
    shorter path). `along` is the part along the surface that the
    tip can reach under that load; what lies across it no lengths can remove, for it is not the dome of the targets.
    The tip of several sections reaches a volume, so there `along` is the whole error; they bend as one arc.
    The controller `pressure` is left out where not all muscles have pressures.
    Exit code 1 if a controller could not follow the spiral; a line says why.
    """
    from contarm_sim.cli.study import deliver, output_for, signed
    from contarm_sim.cli.terminal import track
    from contarm_sim.view.report.study_figures import draw_controllers
    from contarm_sim.view.style import save

    target = output_for(out, "compare-controllers")
    found = studies.compare_controllers(arm, duration, track)

    def draw(folder: Path) -> None:
        save(folder, "controllers", lambda sheet: draw_controllers(sheet, found), prints)

    deliver(target, signed(found), as_json, lambda: _show(found), draw)
    return 1 if any(isinstance(row, studies.NotFollowed) for row in found.rows) else 0


def _show(found: studies.ControllerComparison) -> None:
    from contarm_sim.cli.terminal import table
    from contarm_sim.studies.needs import any_pressure, by_pressure

    columns = ["load", "controller", "rms [%]", "max [%]", "along [%]", "lag [ms]", "tension [N]"]
    columns += ["needs [kPa]", "pushes [%]", "effort [N]"]
    no_need = "more than any" if any_pressure(found.arm) else "-"
    rows = [
        [row.load, row.controller, "failed", *[""] * 7]
        if isinstance(row, studies.NotFollowed)
        else _cells(row, no_need)
        for row in found.rows
    ]
    table(f"spiral, {found.duration:g} s; tip errors in % of backbone length", columns, rows)
    for row in found.rows:
        if isinstance(row, studies.NotFollowed):
            click.echo(f"{row.load}, {row.controller}: failed: {row.failed}")
    if not by_pressure(found.arm):
        click.echo("the controller pressure is left out: it takes an arm whose muscles all have pressures")


def _cells(row: studies.Followed, no_need: str) -> list[str]:
    pressure = row.peak_pressure_pa
    return [
        row.load,
        row.controller,
        f"{row.tip_rms_percent:.3f}",
        f"{row.tip_max_percent:.3f}",
        f"{row.along_rms_percent:.3f}",
        f"{1e3 * row.lag_s + 0.0:.1f}",
        f"{row.peak_tension_n:.1f}",
        no_need if pressure is None else f"{pressure / 1e3:.0f}",
        f"{100 * row.push_fraction:.3g}",
        f"{row.effort_n:.1f}",
    ]

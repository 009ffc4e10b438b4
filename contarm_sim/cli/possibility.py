"""`contarm possibility`: which bends the muscles' pressure can hold, inside the paper's ellipse."""

from __future__ import annotations

from pathlib import Path

import click

from contarm_sim import studies
from contarm_sim.cli.options import Command, arm_options, json_option, out_option
from contarm_sim.model.arm import Arm

PLANES = 12
"""Bending planes in the table."""

GRID_END = 179.5
"""Bends are tried up to here [deg]; what holds there holds any."""


@click.command(cls=Command)
@out_option("runs/possibility-<time>")
@json_option
@arm_options
def possibility(arm: Arm, out: str | None, as_json: bool) -> None:
    """Map the bends that pressures can hold, free, under gravity and with a payload, and draw them.

    The paper's ellipse of muscle lengths says no more than that the bend is below 180 deg. What limits a real arm is
    pressure. Largest bends are in closed form without gravity, by the statics of the simulated arm with it; `simulated`
    holds each of them with all muscles inflated and tells how far the bend that muscle lengths then show is off. The
    picture is in closed form throughout: one uniform bend, under gravity off by a degree or two. Past bends that cannot
    be held there may be others that can.
    """
    from contarm_sim.cli.study import deliver, output_for, signed
    from contarm_sim.cli.terminal import track
    from contarm_sim.studies.scenarios import under_loads
    from contarm_sim.view.report.map import draw_possibility

    target = output_for(out, "possibility")
    found = studies.possibility(arm, PLANES, track)

    def draw(folder: Path) -> None:
        draw_possibility(folder / "possibility.png", under_loads(arm))

    deliver(target, signed(found), as_json, lambda: _show(found), draw)


def _show(found: studies.Possibility) -> None:
    from contarm_sim.cli.terminal import table

    muscle = found.arm.pneumatics
    limits = f"{muscle.min_pressure / 1e3:.0f} to {muscle.max_pressure / 1e3:.0f} kPa"
    columns = ["load", "towards [deg]", "all inflated [deg]", "one may be vented [deg]", "simulated, off by [deg]"]
    table(f"largest bends that {limits} hold", columns, [_cells(row) for row in found.rows])
    said = ", ".join(f"{name} {angle:.1f}" for name, angle in found.every_bend_to_deg.items())
    click.echo(f"in every plane, all muscles inflated, the largest bend is at least: {said} deg")
    for name, angles in found.smaller_bends_not_held_deg.items():
        if angles:
            tried = ", ".join(f"{angle:.0f}" for angle in angles)
            click.echo(f"{name}: smaller bends are NOT all held, the arm falls over: tried {tried} deg")


def _cells(row: studies.LargestBend) -> list[str]:
    off = row.simulated_off_deg
    cells = [row.load, f"{row.plane_deg:.0f}", _angle(row.inflated_deg), _angle(row.vented_deg)]
    if row.inflated_deg <= 0:
        return [*cells, ""]
    return [*cells, "does not rest" if off is None else f"{off:.2f}"]


def _angle(degrees: float) -> str:
    if degrees <= 0:
        return "none"
    return f"{degrees:.1f}" if degrees < GRID_END else "any"

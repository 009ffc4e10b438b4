"""`contarm possibility`: which bends the muscles' pressure can hold, inside the paper's ellipse."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.options import Command, arm_options, json_option, out_option
from contarm_sim.model.arm import Arm

PLANES = 12
"""Bending planes in the table."""


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
    import numpy as np

    from contarm_sim.cli.terminal import command_line, say, table, track
    from contarm_sim.model.arm_file import arm_to_dict
    from contarm_sim.studies.possibility import every_bend, fallen_from, held_off, largest_bends_at_rest
    from contarm_sim.studies.scenarios import under_load
    from contarm_sim.view.report.map import draw_possibility
    from contarm_sim.view.report.output import OutputFolder, check_output, default_folder, to_json, versions

    target = Path(out) if out is not None else default_folder("possibility")
    check_output(target)
    pulled, loaded = under_load(arm)
    arms = {"free": arm.unloaded, "gravity": pulled, "payload": loaded}
    planes = 2 * np.pi * np.arange(PLANES) / PLANES
    rows: list[dict[str, Any]] = []
    least: dict[str, float] = {}
    fallen: dict[str, list[float]] = {}
    for name, one in arms.items():
        inflated, vented = (np.degrees(bends) for bends in largest_bends_at_rest(one, planes))
        least[name] = float(np.degrees(every_bend(one)))
        fallen[name] = np.degrees(fallen_from(one, np.radians(least[name]))).tolist()
        for i in track(range(PLANES), name):
            row = {"load": name, "plane_deg": float(np.degrees(planes[i])), "inflated_deg": float(inflated[i])}
            row["vented_deg"] = float(vented[i])
            off = held_off(one, np.radians(0.999 * inflated[i]), planes[i]) if inflated[i] > 0 else None
            rows.append(row | {"simulated_off_deg": None if off is None else float(np.degrees(off))})
    summary: dict[str, Any] = {
        "rows": rows,
        "every_bend_to_deg": least,
        "smaller_bends_not_held_deg": fallen,
        "arm": arm_to_dict(arm),
        "versions": versions(),
        "command": command_line(),
    }
    with OutputFolder(target) as opened:
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
        draw_possibility(opened.folder / "possibility.png", arms)
    if as_json:
        click.echo(to_json(summary))
    else:
        limits = f"{arm.muscle.min_pressure / 1e3:.0f} to {arm.muscle.max_pressure / 1e3:.0f} kPa"
        columns = ["load", "towards [deg]", "all inflated [deg]", "one may be vented [deg]", "simulated, off by [deg]"]
        table(f"largest bends that {limits} hold", columns, [_cells(row) for row in rows])
        said = ", ".join(f"{name} {angle:.1f}" for name, angle in least.items())
        click.echo(f"in every plane, all muscles inflated, the largest bend is at least: {said} deg")
        for name, angles in fallen.items():
            if angles:
                tried = ", ".join(f"{angle:.0f}" for angle in angles)
                click.echo(f"{name}: smaller bends are NOT all held, the arm falls over: tried {tried} deg")
    say(f"written: {opened.target}")


GRID_END = 179.5
"""Bends are tried up to here [deg]; what holds there holds any."""


def _cells(row: dict[str, Any]) -> list[str]:
    off = row["simulated_off_deg"]
    cells = [row["load"], f"{row['plane_deg']:.0f}", _angle(row["inflated_deg"]), _angle(row["vented_deg"])]
    if row["inflated_deg"] <= 0:
        return [*cells, ""]
    return [*cells, "does not rest" if off is None else f"{off:.2f}"]


def _angle(degrees: float) -> str:
    if degrees <= 0:
        return "none"
    return f"{degrees:.1f}" if degrees < GRID_END else "any"

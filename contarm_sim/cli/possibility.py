"""`contarm possibility`: which bends the muscles' pressure can hold, inside the paper's ellipse."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.arm import Arm
from contarm_sim.cli.options import Command, arm_options, json_option, out_option

PLANES = 12
"""Bending planes in the table."""


@click.command(cls=Command)
@out_option("runs/possibility-<time>")
@json_option
@arm_options
def possibility(arm: Arm, out: str | None, as_json: bool) -> None:
    """Map the bends that pressures can hold, free, under gravity and with a payload, and draw them.

    The paper's ellipse of muscle lengths says no more than that the bend is below 180 deg. What limits a real arm is
    pressure. Largest bends are in closed form; `simulated` holds each of them with its pressures and tells how far the
    bend that muscle lengths then show is off: nothing without gravity, and little with it.
    """
    import numpy as np

    from contarm_sim.arm_file import arm_to_dict
    from contarm_sim.cli.terminal import command_line, say, table, track
    from contarm_sim.report.map import draw_possibility
    from contarm_sim.report.output import OutputFolder, check_output, default_folder, to_json, versions
    from contarm_sim.validation.possibility import held_off, largest_bends
    from contarm_sim.validation.scenarios import under_load

    target = Path(out) if out is not None else default_folder("possibility")
    check_output(target)
    pulled, loaded = under_load(arm)
    arms = {"free": arm.unloaded, "gravity": pulled, "payload": loaded}
    planes = 2 * np.pi * np.arange(PLANES) / PLANES
    rows: list[dict[str, Any]] = []
    for name, one in arms.items():
        inflated, vented = (np.degrees(bends) for bends in largest_bends(one, planes))
        for i in track(range(PLANES), name):
            row = {"load": name, "plane_deg": float(np.degrees(planes[i])), "inflated_deg": float(inflated[i])}
            row["vented_deg"] = float(vented[i])
            off = held_off(one, np.radians(0.999 * inflated[i]), planes[i]) if inflated[i] > 0 else None
            rows.append(row | {"simulated_off_deg": None if off is None else float(np.degrees(off))})
    summary = {"rows": rows, "arm": arm_to_dict(arm), "versions": versions(), "command": command_line()}
    with OutputFolder(target) as opened:
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
        draw_possibility(opened.folder / "possibility.png", arms)
    if as_json:
        click.echo(to_json(summary))
    else:
        limits = f"{arm.muscle.min_pressure / 1e3:.0f} to {arm.muscle.max_pressure / 1e3:.0f} kPa"
        columns = ["load", "towards [deg]", "all inflated [deg]", "one may be vented [deg]", "simulated, off by [deg]"]
        table(f"largest bends that {limits} hold", columns, [_cells(row) for row in rows])
    say(f"written: {opened.target}")


def _cells(row: dict[str, Any]) -> list[str]:
    off = row["simulated_off_deg"]
    largest = [f"{row[key]:.1f}" if row[key] > 0 else "none" for key in ("inflated_deg", "vented_deg")]
    return [row["load"], f"{row['plane_deg']:.0f}", *largest, "" if off is None else f"{off:.2f}"]

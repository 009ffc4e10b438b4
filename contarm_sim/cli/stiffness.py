"""`contarm stiffness`: one pose, more and more co-contraction, and how stiff the tip gets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.options import Command, arm_options, json_option, out_option
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@click.option(
    "--bend", type=float, nargs=2, default=(1.0471975512, 0.0), metavar="BEND_ANGLE PLANE_ANGLE",
    help="Pose to hold [rad]; default 60 deg towards muscle 1.",
)  # fmt: skip
@click.option("--levels", type=click.IntRange(2, 50), default=6, show_default=True, help="Levels of co-contraction.")
@out_option("runs/stiffness-<time>")
@json_option
@arm_options
def stiffness(arm: Arm, bend: Any, levels: int, out: str | None, as_json: bool) -> None:
    """Hold one pose without gravity, raise co-contraction from the lowest to the highest pressure, and probe the tip.

    Directions: `bending` towards more bend, `sideways` out of the bending plane, `along` normal to both. Each
    stiffness is given in closed form and as the simulated arm under pressure shows it when pushed.
    """
    import numpy as np

    from contarm_sim.cli.terminal import command_line, say, table, track
    from contarm_sim.kinematics import arc
    from contarm_sim.model.arm_file import arm_to_dict
    from contarm_sim.studies.cocontraction import DIRECTIONS, stiffness_levels
    from contarm_sim.view.report.figures import draw_stiffness
    from contarm_sim.view.report.output import OutputFolder, check_output, default_folder, to_json, versions

    target = Path(out) if out is not None else default_folder("stiffness")
    check_output(target)
    if any(arm.gravity) or arm.payload:
        say("gravity and payload are left out: the pose is held without them")
    arm = arm.unloaded
    vector = arc.from_polar(*bend)
    rows = stiffness_levels(arm, vector, levels, track)
    summary = {"rows": rows, "bend": vector.tolist(), "directions": DIRECTIONS, "arm": arm_to_dict(arm)}
    summary |= {"versions": versions(), "command": command_line()}
    with OutputFolder(target) as opened:
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
        draw_stiffness(opened.folder / "stiffness.png", rows, DIRECTIONS)
    if as_json:
        click.echo(to_json(summary))
    else:
        columns = ["least tension [N]", "pressures [kPa]", *(f"{name} [N/m]" for name in DIRECTIONS)]
        title = f"tip stiffness at {np.degrees(bend[0]):.0f} deg: simulated (closed form)"
        table(title, [*columns, "drift [%]"], [_cells(row) for row in rows])
        ends = zip(DIRECTIONS, rows[0]["simulated_n_per_m"], rows[-1]["simulated_n_per_m"], strict=True)
        said = ", ".join(
            f"{name} {last / first:.2f} x" if first and last else f"{name} rigid" for name, first, last in ends
        )
        click.echo(f"from the lowest to the highest co-contraction: {said}")
    say(f"written: {opened.target}")


def _cells(row: dict[str, Any]) -> list[str]:
    both = zip(row["simulated_n_per_m"], row["closed_form_n_per_m"], strict=True)
    return [
        f"{row['least_tension_n']:.1f}",
        " ".join(f"{p / 1e3:.0f}" for p in row["pressures_pa"]),
        *(f"{simulated:.3g} ({closed:.3g})" if simulated and closed else "rigid" for simulated, closed in both),
        f"{row['drift_percent']:.3f}",
    ]

"""`contarm stiffness`: one pose, more and more co-contraction, and how stiff the tip gets."""

from __future__ import annotations

import math
from pathlib import Path

import click

from contarm_sim import studies
from contarm_sim.cli.options import ANGLE, Command, arm_options, json_option, out_option
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@click.option(
    "--bend", type=ANGLE, nargs=2, default=(1.0471975512, 0.0), metavar="BEND_ANGLE PLANE_ANGLE",
    help="Pose to hold [rad]; default 60 deg towards muscle 1.",
)  # fmt: skip
@click.option("--levels", type=click.IntRange(2, 50), default=6, show_default=True, help="Levels of co-contraction.")
@out_option("runs/stiffness-<time>")
@json_option
@arm_options
def stiffness(arm: Arm, bend: tuple[float, float], levels: int, out: str | None, as_json: bool) -> None:
    """Hold one pose without gravity, raise co-contraction from the lowest to the highest pressure, and probe the tip.

    Directions: `bending` towards more bend, `sideways` out of the bending plane, `along` normal to both. Each
    stiffness is given in closed form and as the simulated arm under pressure shows it when pushed.
    """
    from contarm_sim.cli.study import deliver, output_for, signed
    from contarm_sim.cli.terminal import say, track
    from contarm_sim.kinematics import arc
    from contarm_sim.view.report.figures import draw_stiffness

    target = output_for(out, "stiffness")
    if any(arm.gravity) or arm.payload:
        say("gravity and payload are left out: the pose is held without them")
    found = studies.stiffness(arm, arc.from_polar(*bend), levels, track)

    def draw(folder: Path) -> None:
        draw_stiffness(folder / "stiffness.png", found)

    deliver(target, signed(found), as_json, lambda: _show(found, bend[0]), draw)


def _show(found: studies.Stiffness, bend_angle: float) -> None:
    from contarm_sim.cli.terminal import table

    columns = ["least tension [N]", "pressures [kPa]", *(f"{name} [N/m]" for name in found.directions)]
    title = f"tip stiffness at {math.degrees(bend_angle):.0f} deg: simulated (closed form)"
    table(title, [*columns, "drift [%]"], [_cells(row) for row in found.rows])
    ends = zip(found.directions, found.rows[0].simulated_n_per_m, found.rows[-1].simulated_n_per_m, strict=True)
    said = ", ".join(
        f"{name} {last / first:.2f} x" if math.isfinite(first) and math.isfinite(last) else f"{name} rigid"
        for name, first, last in ends
    )
    click.echo(f"from the lowest to the highest co-contraction: {said}")


def _cells(row: studies.StiffnessLevel) -> list[str]:
    both = zip(row.simulated_n_per_m, row.closed_form_n_per_m, strict=True)
    return [
        f"{row.least_tension_n:.1f}",
        " ".join(f"{p / 1e3:.0f}" for p in row.pressures_pa),
        *(f"{s:.3g} ({c:.3g})" if math.isfinite(s) and math.isfinite(c) else "rigid" for s, c in both),
        f"{row.drift_percent:.3f}",
    ]

"""`contarm stiffness`: one pose, more and more co-contraction, and how stiff the tip gets."""

from __future__ import annotations

import math
from pathlib import Path

import click

from contarm_sim import studies
from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import Command, arm_options, bend_option, bends_from_words, json_option, out_option
from contarm_sim.model.arm import Arm
from contarm_sim.view.prints import Prints

DEFAULT, OF_SECTIONS = (1.0471975512, 0.0), (0.5235987756, 0.0)
"""Bend and plane angle [rad] of the only section, and of each of several, unless others are given."""


@click.command(cls=Command)
@bend_option("Pose to hold [rad]; once for each section; default 60 deg towards +X, of several sections 30 deg each.")
@click.option("--levels", type=click.IntRange(2, 50), default=6, show_default=True, help="Levels of co-contraction.")
@out_option("runs/stiffness-<time>")
@figure_options()
@json_option
@arm_options
def stiffness(
    arm: Arm, bend: tuple[tuple[float, float], ...], levels: int, out: str | None, prints: Prints, as_json: bool
) -> None:
    """Hold one pose without gravity, raise co-contraction from the lowest to the highest pressure, and probe the tip.

    Directions: `bending` towards more bend, `sideways` out of the bending plane, `along` normal to both; of several
    sections, where the tip goes as all bends grow, sideways of that and of where the tip points, and normal to both.
    Each stiffness is given in closed form and as the simulated arm under pressure shows it when pushed.
    """
    from contarm_sim.cli.study import deliver, output_for, signed
    from contarm_sim.cli.terminal import say, track
    from contarm_sim.view.report.study_figures import draw_stiffness
    from contarm_sim.view.style import save

    target = output_for(out, "stiffness")
    bend = bend or (DEFAULT if len(arm.sections) == 1 else OF_SECTIONS,) * len(arm.sections)
    pose = bends_from_words(bend, arm)
    found = studies.stiffness(arm, pose, levels, track)
    if any(arm.gravity) or arm.payload:
        say("gravity and payload are left out: the pose is held without them")

    def draw(folder: Path) -> None:
        save(folder, "stiffness", lambda sheet: draw_stiffness(sheet, found), prints)

    deliver(target, signed(found), as_json, lambda: _show(found, [angle for angle, _ in bend]), draw)


def _show(found: studies.Stiffness, angles: list[float]) -> None:
    from contarm_sim.cli.terminal import table

    columns = ["least tension [N]", "pressures [kPa]", *(f"{name} [N/m]" for name in found.directions)]
    bent = ", ".join(f"{math.degrees(angle):.0f}" for angle in angles)
    title = f"tip stiffness at {bent} deg: simulated (closed form)"
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

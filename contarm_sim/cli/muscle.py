"""`contarm muscle`: force of one pneumatic muscle against contraction and pressure."""

from __future__ import annotations

from pathlib import Path

import click

from contarm_sim.cli.options import Command, arm_options, json_option
from contarm_sim.model.arm import Arm

PRESSURES = (100e3, 200e3, 300e3, 400e3, 500e3, 600e3, 700e3)


@click.command(cls=Command)
@click.option(
    "--pressure", type=float, multiple=True, metavar="P ...", help="Gauge pressures [Pa]; default 100 to 700 kPa."
)
@click.option(
    "--out", metavar="PICTURE.png", help="Draw the curves too, into a .png, .pdf or .svg that does not exist."
)
@json_option
@arm_options
def muscle(arm: Arm, pressure: tuple[float, ...], out: str | None, as_json: bool) -> None:
    """Show the force of one muscle by contraction and pressure (McKibben law, static, without friction).

    \b
    contarm muscle
    contarm muscle --pressure 250000 500000 --out muscle.png
    """
    import numpy as np

    from contarm_sim.cli.terminal import table
    from contarm_sim.errors import InputError
    from contarm_sim.mechanics.pneumatics import force
    from contarm_sim.view.report.output import check_output, output_file, to_json

    given = pressure or tuple(p for p in PRESSURES if p <= arm.muscle.max_pressure) or (arm.muscle.max_pressure,)
    for p in given:
        if not 0 <= p <= arm.muscle.max_pressure:
            raise InputError("pressure", p, f"0 to {arm.muscle.max_pressure:g} Pa")
    if out is not None:
        if Path(out).suffix not in (".png", ".pdf", ".svg"):
            raise InputError("out", out, "a name that ends in .png, .pdf or .svg")
        check_output(Path(out))
    contraction = np.linspace(-arm.muscle.max_stretch, arm.muscle.max_contraction, 9)
    forces = force(np.array(given)[:, None], arm.muscle_rest_length * (1 - contraction), arm)
    if out is not None:
        from contarm_sim.view.report.figures import draw_muscle_law

        with output_file(Path(out)) as scratch:
            draw_muscle_law(scratch, arm, given, Path(out).suffix[1:])
    if as_json:
        found = {"pressure_pa": list(given), "contraction": contraction.tolist(), "force_n": forces.tolist()}
        found |= {"braid_angle_rad": arm.muscle.braid_angle, "rest_length_m": arm.muscle_rest_length}
        found |= {"blocked_force_n": arm.muscle.blocked_force, "max_stretch": arm.muscle.max_stretch}
        click.echo(to_json(found))
        return
    columns = ["contraction [%]", *(f"{p / 1e3:g} kPa [N]" for p in given)]
    rows = [
        [f"{100 * c:.1f}", *(f"{f + 0.0:.1f}" for f in line)] for c, line in zip(contraction, forces.T, strict=True)
    ]
    at_rest = f"rest length {1e3 * arm.muscle_rest_length:.1f} mm, {1e3 * arm.length:.0f} mm in the straight arm"
    table(
        "Force of one muscle; a negative contraction is stretch, up to where the braid closes", columns, rows, at_rest
    )

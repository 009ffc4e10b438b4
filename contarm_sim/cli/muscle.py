"""`contarm muscle`: force of one pneumatic muscle against contraction and pressure."""

from __future__ import annotations

from pathlib import Path

import click

from contarm_sim import studies
from contarm_sim.cli.options import PRESSURE, Command, arm_options, json_option
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@click.option(
    "--pressure", type=PRESSURE, multiple=True, metavar="P ...", help="Gauge pressures [Pa]; default 100 to 700 kPa."
)
@click.option("--section", type=int, metavar="N", help="Of several sections, the one whose muscle it is; from 1.")
@click.option(
    "--out", metavar="PICTURE.png", help="Draw the curves too, into a .png, .pdf or .svg that does not exist."
)
@json_option
@arm_options
def muscle(arm: Arm, pressure: tuple[float, ...], section: int | None, out: str | None, as_json: bool) -> None:
    """Show the force of one muscle by contraction and pressure (McKibben law, static, without friction).

    \b
    contarm muscle
    contarm muscle --pressure 250000 500000 --out muscle.png
    """
    from contarm_sim.errors import InputError
    from contarm_sim.results.document import document
    from contarm_sim.studies.muscle_curves import group_of
    from contarm_sim.view.report.output import check_output, output_file, to_json

    found, group = studies.muscle_law(arm, pressure, section=section), group_of(arm, section)
    if out is not None:
        if Path(out).suffix not in (".png", ".pdf", ".svg"):
            raise InputError("out", out, "a name that ends in .png, .pdf or .svg")
        check_output(Path(out))
        from contarm_sim.view.report.study_figures import draw_muscle_law
        from contarm_sim.view.style import drawn, write

        with output_file(Path(out)) as scratch:
            write(drawn(lambda sheet: draw_muscle_law(sheet, group, found.pressure_pa)), scratch)
    if as_json:
        click.echo(to_json(document(found)))
    else:
        _show(found, group.length)


def _show(found: studies.MuscleCurves, straight: float) -> None:
    from contarm_sim.cli.terminal import table

    columns = ["contraction [%]", *(f"{p / 1e3:g} kPa [N]" for p in found.pressure_pa)]
    rows = [
        [f"{100 * c:.1f}", *(f"{f + 0.0:.1f}" for f in line)]
        for c, line in zip(found.contraction, found.force_n.T, strict=True)
    ]
    at_rest = f"rest length {1e3 * found.rest_length_m:.1f} mm, {1e3 * straight:.0f} mm in the straight arm"
    table(
        "Force of one muscle; a negative contraction is stretch, up to where the braid closes", columns, rows, at_rest
    )

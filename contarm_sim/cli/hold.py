"""`contarm hold`: the tensions and pressures that hold a bend."""

from __future__ import annotations

import math

import click

from contarm_sim import studies
from contarm_sim.cli.options import ANGLE, PLAIN, Command, arm_options, json_option
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@click.option(
    "--bend", type=ANGLE, nargs=2, required=True, metavar="BEND_ANGLE PLANE_ANGLE", help="Pose to hold [rad]."
)
@click.option(
    "--share", type=PLAIN, default=0.0, show_default=True, metavar="X",
    help="Co-contraction, from 0, the least that pressures allow, to 1, the most.",
)  # fmt: skip
@json_option
@arm_options
def hold(arm: Arm, bend: tuple[float, float], share: float, as_json: bool) -> int:
    """Print the muscle lengths, tensions and pressures that hold a bend, in closed form.

    Under gravity and payload they balance the weight's moment on the bend as a whole, not the sag between. The
    simulated arm is put under these pressures; exit code 1 if it does not stay near the bend.

    \b
    contarm hold --bend 1.5708 0
    contarm hold --bend 1.2 0.5 --share 1 --gravity 0 0 9.81 --payload 0.1
    """
    from contarm_sim.kinematics import arc
    from contarm_sim.results.document import document
    from contarm_sim.view.report.output import to_json

    found = studies.hold(arm, arc.from_polar(*bend), share)
    if as_json:
        click.echo(to_json(document(found)))
    else:
        _show(found)
    return 0 if found.simulated_off is not None else 1


def _show(found: studies.Hold) -> None:
    from contarm_sim.cli.terminal import table

    each = zip(found.muscle_lengths, found.actuator_tensions, found.pressures, strict=True)
    rows = [[f"muscle {i}", f"{1e3 * x:.2f}", f"{f:.2f}", f"{p / 1e3:.1f}"] for i, (x, f, p) in enumerate(each, 1)]
    table("what holds the bend", ["", "length [mm]", "force [N]", "pressure [kPa]"], rows)
    low, high = found.level_range
    click.echo(f"co-contraction can rise by {high - low:.1f} N a muscle within the limits of pressure")
    off = found.simulated_off
    if off is None:
        click.echo("NOT HELD: under these pressures the simulated arm does not stay there")
    else:
        click.echo(f"under these pressures the simulated arm rests {math.degrees(off):.2f} deg from that bend")

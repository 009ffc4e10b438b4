"""`contarm hold`: the tensions and pressures that hold a bend."""

from __future__ import annotations

from typing import Any

import click

from contarm_sim.arm import Arm
from contarm_sim.cli.options import Command, arm_options, json_option
from contarm_sim.errors import InputError


@click.command(cls=Command)
@click.option(
    "--bend", type=float, nargs=2, required=True, metavar="BEND_ANGLE PLANE_ANGLE", help="Pose to hold [rad]."
)
@click.option(
    "--share", type=float, default=0.0, show_default=True, metavar="X",
    help="Co-contraction, from 0, the least that pressures allow, to 1, the most.",
)  # fmt: skip
@json_option
@arm_options
def hold(arm: Arm, bend: Any, share: float, as_json: bool) -> None:
    """Print the muscle lengths, tensions and pressures that hold a bend, in closed form.

    Under gravity and payload they balance the weight's moment on the bend as a whole, not the sag between.

    \b
    contarm hold --bend 1.5708 0
    contarm hold --bend 1.2 0.5 --share 1 --gravity 0 0 9.81 --payload 0.1
    """
    from contarm_sim.cli.terminal import table
    from contarm_sim.kinematics import arc
    from contarm_sim.mechanics import routing
    from contarm_sim.mechanics.statics import balance, holding_pressures, level_range, weight_moment
    from contarm_sim.report.output import to_json

    if not 0 <= share <= 1:
        raise InputError("share", share, "0 to 1")
    vector = arc.as_bend(arc.from_polar(*bend))
    held = balance(vector, arm)
    pressures = holding_pressures(vector, arm, share)
    low, high = (float(x) for x in level_range(held, arm))
    tensions = pressures * held.per_pascal
    lengths = routing.lengths_from_bend(vector, arm)
    if as_json:
        found = {"bend": vector.tolist(), "muscle_lengths": lengths.tolist(), "muscle_forces": tensions.tolist()}
        found |= {"pressures": pressures.tolist(), "weight_moment": weight_moment(vector, arm).tolist()}
        found |= {"cocontraction": held.cocontraction.tolist(), "level": low + share * (high - low)}
        click.echo(to_json(found | {"level_range": [low, high]}))
        return
    rows = [
        [f"muscle {i + 1}", f"{1e3 * lengths[i]:.2f}", f"{tensions[i]:.2f}", f"{pressures[i] / 1e3:.1f}"]
        for i in range(3)
    ]
    table("what holds the bend", ["", "length [mm]", "force [N]", "pressure [kPa]"], rows)
    click.echo(f"co-contraction can rise by {high - low:.1f} N a muscle within the limits of pressure")

"""`contarm hold`: the tensions and pressures that hold a bend."""

from __future__ import annotations

import math
from typing import Any

import click

from contarm_sim.cli.options import Command, arm_options, json_option
from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm

NEAR = math.radians(10)
"""How far from a bend, which is balanced as a whole under load, the simulated arm still counts as held there [rad]."""


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
def hold(arm: Arm, bend: Any, share: float, as_json: bool) -> int:
    """Print the muscle lengths, tensions and pressures that hold a bend, in closed form.

    Under gravity and payload they balance the weight's moment on the bend as a whole, not the sag between. The
    simulated arm is put under these pressures; exit code 1 if it does not stay near the bend.

    \b
    contarm hold --bend 1.5708 0
    contarm hold --bend 1.2 0.5 --share 1 --gravity 0 0 9.81 --payload 0.1
    """
    from contarm_sim.cli.terminal import table
    from contarm_sim.kinematics import arc
    from contarm_sim.mechanics import routing
    from contarm_sim.mechanics.statics import balance, holding_pressures, level_range, weight_moment
    from contarm_sim.view.report.output import to_json

    if not 0 <= share <= 1:
        raise InputError("share", share, "0 to 1")
    vector = arc.as_bend(arc.from_polar(*bend))
    held = balance(vector, arm)
    pressures = holding_pressures(vector, arm, share)
    low, high = (float(x) for x in level_range(held, arm))
    tensions = pressures * held.per_pascal
    lengths = routing.lengths_from_bend(vector, arm)
    found_off = _off(arm, vector, pressures)
    if as_json:
        found = {"bend": vector.tolist(), "muscle_lengths": lengths.tolist(), "muscle_forces": tensions.tolist()}
        found |= {"pressures": pressures.tolist(), "weight_moment": weight_moment(vector, arm).tolist()}
        found |= {"cocontraction": held.cocontraction.tolist(), "level": low + share * (high - low)}
        click.echo(to_json(found | {"level_range": [low, high], "simulated_off": found_off}))
        return 0 if found_off is not None else 1
    rows = [
        [f"muscle {i + 1}", f"{1e3 * lengths[i]:.2f}", f"{tensions[i]:.2f}", f"{pressures[i] / 1e3:.1f}"]
        for i in range(3)
    ]
    table("what holds the bend", ["", "length [mm]", "force [N]", "pressure [kPa]"], rows)
    click.echo(f"co-contraction can rise by {high - low:.1f} N a muscle within the limits of pressure")
    if found_off is None:
        click.echo("NOT HELD: under these pressures the simulated arm does not stay there")
        return 1
    click.echo(f"under these pressures the simulated arm rests {math.degrees(found_off):.2f} deg from that bend")
    return 0


def _off(arm: Arm, bend: Any, pressures: Any) -> float | None:
    """Return how far from a bend the simulated arm rests under pressures [Pa] [rad]; None if not near."""
    import numpy as np

    from contarm_sim.errors import ConvergenceError
    from contarm_sim.mechanics import routing
    from contarm_sim.model.load import Load, Muscles
    from contarm_sim.statics.equilibrium import equilibrium

    try:
        found = equilibrium(arm, Load(muscles=Muscles(kind="pressures", values=tuple(pressures))))
    except ConvergenceError:
        return None
    off = float(np.hypot(*(routing.bend_from_lengths(found.muscle_lengths, arm)[0] - bend)))
    return off if found.stable and off < NEAR else None

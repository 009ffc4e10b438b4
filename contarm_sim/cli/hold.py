"""`contarm hold`: the tensions and pressures that hold a bend."""

from __future__ import annotations

import math
from typing import Any

import click

from contarm_sim import studies
from contarm_sim.cli.options import PLAIN, Command, arm_options, bend_option, bends_from_words, json_option
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@bend_option("Pose to hold [rad]; once for each section.", required=True)
@click.option(
    "--share", type=PLAIN, default=0.0, show_default=True, metavar="X",
    help="Co-contraction, from 0, the least that pressures allow, to 1, the most.",
)  # fmt: skip
@json_option
@arm_options
def hold(arm: Arm, bend: tuple[tuple[float, float], ...], share: float, as_json: bool) -> int:
    """Print the muscle lengths, tensions and pressures that hold a bend (one for each section), in closed form.

    Under gravity and payload they balance the weight's moment on the bend as a whole, not the sag between. The
    simulated arm is put under these pressures; exit code 1 if it does not stay near the bend.

    \b
    contarm hold --bend 1.5708 0
    contarm hold --bend 1.2 0.5 --share 1 --gravity 0 0 9.81 --payload 0.1
    contarm hold --arm two.toml --bend 60deg 0 --bend 45deg 90deg
    """
    from contarm_sim.results.document import document
    from contarm_sim.view.report.output import to_json

    found = studies.hold(arm, bends_from_words(bend, arm), share)
    if as_json:
        click.echo(to_json(document(found)))
    else:
        _show(found, arm)
    return 0 if found.simulated_off is not None else 1


def _show(found: studies.Hold, arm: Arm) -> None:
    from contarm_sim.cli.terminal import table

    columns = ["", "length [mm]", "force [N]"]
    if found.pressures is not None:
        columns.append("pressure [kPa]")
    off, several = found.simulated_off, len(arm.sections) > 1
    table("what holds the bends" if several else "what holds the bend", columns, _rows(found, several))
    ranges: Any = found.level_range if several else (found.level_range,)
    driven = "pressure" if found.pressures is not None else "tension"
    for number, (low, high) in enumerate(ranges, 1):
        of_section = f"section {number}: " if several else ""
        click.echo(f"{of_section}co-contraction can rise by {high - low:.1f} N a muscle within the limits of {driven}")
    if off is None:
        click.echo(f"NOT HELD: under these {driven}s the simulated arm does not stay there")
    else:
        where = "these bends, at most" if several else "that bend"
        click.echo(f"under these {driven}s the simulated arm rests {math.degrees(off):.2f} deg from {where}")


def _rows(found: studies.Hold, several: bool) -> list[list[str]]:
    numbers: list[Any] = [found.muscle_lengths, found.actuator_tensions]
    if found.pressures is not None:
        numbers.append(found.pressures)
    groups = zip(*numbers, strict=True) if several else [numbers]
    scales = ((1e3, 2), (1.0, 2), (1e-3, 1))
    rows = []
    for section, group in enumerate(groups, 1):
        of_section = f"section {section}, " if several else ""
        for i, own in enumerate(zip(*group, strict=True), 1):
            cells = (f"{scale * x:.{digits}f}" for x, (scale, digits) in zip(own, scales, strict=False))
            rows.append([f"{of_section}muscle {i}", *cells])
    return rows

"""`contarm possibility`: which bends the muscles' pressure can hold, inside the paper's ellipse."""

from __future__ import annotations

from pathlib import Path

import click

from contarm_sim import studies
from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import Command, arm_options, bend_option, bends_from_words, json_option, out_option
from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.view.prints import Prints

PLANES = 12
"""Bending planes in the table."""

PLANES_OF_SECTIONS = 6
"""The same of each of several sections: there are more of them."""

GRID_END = 179.5
"""Bends are tried up to here [deg]; what holds there holds any."""


@click.command(cls=Command)
@bend_option("Of several sections, the pose of those that do not bend [rad]; once for each section; default straight.")
@out_option("runs/possibility-<time>")
@figure_options()
@json_option
@arm_options
def possibility(
    arm: Arm, bend: tuple[tuple[float, float], ...], out: str | None, prints: Prints, as_json: bool
) -> None:
    """Map the bends that pressures can hold, free, under gravity and with a payload, and draw them.

    The paper's ellipse of muscle lengths says no more than that the bend is below 180 deg. What limits a real arm is
    pressure. Largest bends are in closed form without gravity, by the statics of the simulated arm with it; `simulated`
    holds each of them with all muscles inflated and tells how far the bend that muscle lengths then show is off. The
    picture is in closed form throughout: one uniform bend, under gravity off by a degree or two. Past bends that cannot
    be held there may be others that can.

    Of several sections one after the other bends while the others stay straight, or as --bend says; all muscles of the
    arm must hold. There is no picture of these, nor of other muscles than three evenly spaced ones with
    pressures; a line says so. Muscles without pressures pull with up to their highest tension.

    \b
    contarm possibility
    contarm possibility --arm two.toml --bend 30deg 0 --bend 30deg 180deg
    """
    from contarm_sim.cli.study import deliver, output_for, signed
    from contarm_sim.cli.terminal import say, track
    from contarm_sim.studies.scenarios import under_loads
    from contarm_sim.view.report.map import draw_possibility, no_map
    from contarm_sim.view.style import save

    target = output_for(out, "possibility")
    several = len(arm.sections) > 1
    if bend and not several:
        allowed = "none: only the other sections of several have one"
        raise InputError("--bend", "given for an arm of one section", allowed)
    given = {"others": bends_from_words(bend, arm)} if bend else {}
    found = studies.possibility(arm, PLANES_OF_SECTIONS if several else PLANES, track, **given)

    missing = no_map(arm)

    def draw(folder: Path) -> None:
        if not missing:
            save(folder, "possibility", lambda sheet: draw_possibility(sheet, under_loads(arm)), prints)

    left_out = {"left_out": {"possibility": f"needs {missing}"}} if missing else {}
    deliver(target, signed(found) | left_out, as_json, lambda: _show(found), draw)
    if missing:
        say(f"no map is drawn: it needs {missing}")


def _show(found: studies.Possibility) -> None:
    from contarm_sim.cli.terminal import table
    from contarm_sim.studies.needs import any_pressure, by_pressure

    several = len(found.arm.sections) > 1
    full, empty = ("inflated", "vented") if by_pressure(found.arm) else ("taut", "slack")
    if any_pressure(found.arm) and not by_pressure(found.arm):
        full, empty = "inflated or taut", "vented or slack"
    columns = ["load", "towards [deg]", f"all {full} [deg]", f"one may be {empty} [deg]", "simulated, off by [deg]"]
    if several:
        columns.insert(1, "section")
    table(f"largest bends that {_limits(found.arm)} hold", columns, [_cells(row) for row in found.rows])
    for number in range(len(found.arm.sections)):
        least = {name: each[number] if several else each for name, each in found.every_bend_to_deg.items()}
        said = ", ".join(f"{name} {angle:.1f}" for name, angle in least.items())
        of_section = f"section {number + 1}: " if several else ""
        click.echo(f"{of_section}in every plane, all muscles {full}, the largest bend is at least: {said} deg")
        for name, each in found.smaller_bends_not_held_deg.items():
            angles = each[number] if several else each
            if angles:
                tried = ", ".join(f"{angle:.0f}" for angle in angles)
                click.echo(f"{of_section}{name}: smaller bends are NOT all held, the arm falls over: tried {tried} deg")


def _limits(arm: Arm) -> str:
    """Say what the muscles of all sections have: pressures, or tensions."""
    from contarm_sim.model.pneumatic_law import PneumaticLaw

    said = []
    for group in arm.groups:
        law = group.law
        limits = f"{law.min_tension:g} to {law.blocked_force:g} N"
        if isinstance(law, PneumaticLaw):
            limits = f"{law.min_pressure / 1e3:.0f} to {law.max_pressure / 1e3:.0f} kPa"
        if limits not in said:
            said.append(limits)
    return " and ".join(said)


def _cells(row: studies.LargestBend) -> list[str]:
    off = row.simulated_off_deg
    cells = [row.load, *([] if row.section is None else [str(row.section)]), f"{row.plane_deg:.0f}"]
    cells += [_angle(row.inflated_deg), _angle(row.vented_deg)]
    if row.inflated_deg <= 0:
        return [*cells, ""]
    return [*cells, "does not rest" if off is None else f"{off:.2f}"]


def _angle(degrees: float) -> str:
    if degrees <= 0:
        return "none"
    return f"{degrees:.1f}" if degrees < GRID_END else "any"

"""`contarm trust`: when may constant curvature be trusted, for one's own arm."""

from __future__ import annotations

from pathlib import Path

import click

from contarm_sim import studies
from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import ANGLE, Command, Percent, arm_options, json_option, out_option
from contarm_sim.model.arm import Arm
from contarm_sim.view.prints import Prints


@click.command(cls=Command)
@click.option(
    "--bend", type=ANGLE, metavar="ANGLE",
    help="Bend that you want to go to [rad]; default 120deg, of several sections 60deg each.",
)  # fmt: skip
@click.option(
    "--within", type=Percent(), default=1.0, show_default=True, metavar="PERCENT",
    help="Tip error up to which constant curvature holds for you [% of length].",
)  # fmt: skip
@click.option(
    "--planes", type=click.IntRange(1, 360), default=12, show_default=True, metavar="N",
    help="Bending planes that are tried, evenly spaced.",
)  # fmt: skip
@out_option("runs/trust-<time>")
@figure_options()
@json_option
@arm_options
def trust(arm: Arm, bend: float | None, within: float, planes: int, out: str | None, prints: Prints,
          as_json: bool) -> None:  # fmt: skip
    """Say how far your arm may bend before the constant-curvature model is off by more than you allow.

    The arm is simulated at rest, bend by bend, in every bending plane: without gravity, under its gravity, and with
    its payload. One without gravity of its own is taken to hang, with and without 100 g, and to stand. Says the
    largest bends within 0.1, 1 and 5 % of length, and what bending stiffness, mass or payload it would take to go to
    --bend. All sections of several bend alike.

    \b
    contarm trust
    contarm trust --arm my_arm.toml --bend 90deg --within 2
    contarm trust --gravity 9.81 0 0 --payload 0.2 --figures pdf --figure-width column --no-titles
    """
    from contarm_sim.cli.study import deliver, output_for, signed
    from contarm_sim.cli.terminal import track
    from contarm_sim.view.report.trust import draw_trust, paragraph, remedies
    from contarm_sim.view.style import save

    target = output_for(out, "trust")
    found = studies.trust(arm, bend, within, planes, track)
    words = paragraph(found)

    def draw(folder: Path) -> None:
        save(folder, "trust", lambda sheet: draw_trust(sheet, found), prints)

    summary = signed(found) | {"in_words": words, "what_it_would_take": remedies(found)}
    deliver(target, summary, as_json, lambda: _show(found, words), draw)


def _show(found: studies.Trust, words: str) -> None:
    from contarm_sim.cli.terminal import table, width
    from contarm_sim.view.report.trust import remedies

    bounds = [bend.within_percent for bend in found.loads[0].trusted.bends]
    columns = ["load", "m g L^2/EI", *(f"{bound:g} % [deg]" for bound in bounds), "in plane [deg]", "muscles to [deg]"]
    rows = [_cells(found, each) for each in found.loads]
    table("largest bends at which constant curvature holds, by tip error", columns, rows, _caption(found))
    line = min(width(), 120)
    click.echo(click.wrap_text(words, line))
    for number, words in enumerate(remedies(found)):
        if number == 0:
            click.echo(f"To be within {found.within_percent:g} % up to {found.wanted_bend_deg:g} deg it would take")
        click.echo(click.wrap_text(words, line, initial_indent="  ", subsequent_indent="    "))


def _caption(found: studies.Trust) -> str:
    """Return what the columns mean, and what twice the links would make of the bends."""
    lines = [
        "m g L^2/EI: weight, with the payload, over stiffness; "
        f"in plane: the worst one, within {found.within_percent:g} %",
        "muscles to: the largest bend tried for which they have the tension and pressure",
    ]
    finer = [
        f"{each.trusted.under.meaning} {', '.join(_deg(found, deg) for deg in each.twice_the_links_deg)}"
        for each in found.loads
        if each.twice_the_links_deg is not None
    ]
    if finer:
        lines.append(f"with twice the links: {'; '.join(finer)}")
    if any(bend.no_rest for each in found.loads for bend in each.trusted.bends):
        lines.append("* beyond it the arm has no pose at rest (not looked at with twice the links)")
    return "\n".join(lines)


def _deg(found: studies.Trust, degrees: float) -> str:
    return "any" if degrees >= found.max_bend_deg else f"{degrees:.1f}"


def _cells(found: studies.Trust, each: studies.TrustUnderLoad) -> list[str]:
    own, under = each.trusted.bends, each.trusted.under
    bends = ["any" if bend.everywhere else f"{bend.least_deg:.1f}{'*' * bool(bend.no_rest)}" for bend in own]
    asked = each.trusted.within(found.within_percent)
    alike = asked.everywhere or asked.bend_deg.max() - asked.least_deg < 0.1
    worst = "all" if alike else f"{asked.towards_deg:.0f}"
    return [under.meaning, f"{under.weight_over_stiffness:.2f}", *bends, worst, f"{each.trusted.muscles_to_deg:.0f}"]

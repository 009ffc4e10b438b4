"""`contarm sweep-report`: a sweep in pictures and on a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import Command, json_option, out_option
from contarm_sim.view.prints import Prints

if TYPE_CHECKING:
    from contarm_sim.view.report.sweeps.found import Found


@click.command(cls=Command, name="sweep-report")
@click.argument("sweep", metavar="FOLDER")
@click.option("--quantity", metavar="NAME", help="What is reported; default the largest tip error, or the first asked.")
@out_option("runs/sweep-report-<time>")
@figure_options()
@json_option
def sweep_report(sweep: str, quantity: str | None, out: str | None, prints: Prints, as_json: bool) -> None:
    """Draw what contarm sweep found, done or not: figures, and a page with counts and extreme cases.

    Leaves report.html, summary.json and the figures heat_map (over the two parameters of the largest effect),
    marginals (by each parameter alone), indices (Sobol's, with 95 % intervals; of design = "sobol-indices"), failures
    (where, and why) and, of a sweep like validity, the chart that says when constant curvature may be trusted.

    \b
    contarm sweep validity && contarm sweep-report runs/sweep-validity
    contarm sweep-report runs/sweep-soft --quantity tension_max
    contarm sweep-report runs/sweep-validity --figures pdf,png --figure-width both --no-titles
    """
    from contarm_sim import sweeps
    from contarm_sim.cli.study import deliver, output_for, signed
    from contarm_sim.view.report.sweeps.found import found_of
    from contarm_sim.view.report.sweeps.page import write_sweep_report
    from contarm_sim.view.report.sweeps.words import headline

    target = output_for(out, "sweep-report")
    found = found_of(sweeps.load(sweep), quantity)
    summary = signed(found.document()) | {"in_words": headline(found).replace("`", "")}

    def draw(folder: Path) -> None:
        write_sweep_report(folder, found, summary, prints)

    deliver(target, summary, as_json, lambda: _show(found), draw)


def _show(found: Found) -> None:
    from contarm_sim.cli.terminal import table, width
    from contarm_sim.view.report.sweeps import words

    columns, rows = words.cases(found)
    if rows:
        table(f"{found.value.words}: extreme cases", columns, rows)
    line = min(width(), 120)
    click.echo(click.wrap_text(words.headline(found).replace("`", ""), line))
    for each in words.standings(found):
        click.echo(click.wrap_text(f"{each.title} {each.text}".replace("`", ""), line))
    for remark in words.remarks(found):
        click.echo(click.wrap_text(f"{remark[0].upper()}{remark[1:]}.", line))

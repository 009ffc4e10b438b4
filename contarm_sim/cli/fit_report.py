"""`contarm fit-report`: the report of a fit, drawn again."""

from __future__ import annotations

import json
from pathlib import Path

import click

from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import Command, json_option
from contarm_sim.view.prints import Prints


@click.command(cls=Command, name="fit-report")
@click.argument("folder", metavar="FOLDER")
@click.option("--out", metavar="PATH", help="Where to write; must not exist yet. Default: FOLDER itself, anew.")
@figure_options()
@json_option
def fit_report(folder: str, out: str | None, prints: Prints, as_json: bool) -> None:
    """Draw what contarm fit left, without fitting: report.html and its figures.

    The page says how well what was held out is predicted; each parameter with its 95 % interval; what the recording
    does not determine; errors by marker, by block, over time, by command, and by the way that a command went.

    \b
    contarm fit-report runs/fit-20260101-120000
    contarm fit-report runs/fit-20260101-120000 --out print --figures pdf --figure-width both --no-titles
    """
    from contarm_sim.cli.fit import show
    from contarm_sim.cli.study import deliver, output_for
    from contarm_sim.cli.terminal import command_line, say
    from contarm_sim.files import write_whole
    from contarm_sim.identify.fit_folder import load_fit
    from contarm_sim.inputs import read_text
    from contarm_sim.view.report.fits.page import write_fit_report
    from contarm_sim.view.report.fits.summary import summary_of
    from contarm_sim.view.report.output import to_json

    found = load_fit(folder)
    kept = Path(folder) / "summary.json"
    known = kept.is_file()  # save_fit writes none
    summary = json.loads(read_text(kept, "what contarm fit left")) if known else summary_of(found, command_line())
    if out is not None:
        deliver(output_for(out, "fit-report"), summary, as_json, lambda: show(found),
                lambda target: write_fit_report(target, found, summary, prints))  # fmt: skip
        return
    if not known:
        write_whole(kept, to_json(summary) + "\n")
    write_fit_report(Path(folder), found, summary, prints)
    click.echo(to_json(summary)) if as_json else show(found)
    say(f"written: {Path(folder) / 'report.html'}")

"""`contarm figures`: the paper's figures and ours, computed and drawn."""

from __future__ import annotations

from pathlib import Path

import click

from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import Command, arm_options, json_option, out_option
from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.view.prints import Prints


@click.command(cls=Command)
@click.argument("names", nargs=-1, metavar="[NAME ...]")
@click.option("--list", "listing", is_flag=True, help="Name the figures and what they show.")
@out_option("runs/figures-<time>")
@figure_options("png,pdf,svg")
@json_option
@arm_options
def figures(arm: Arm, names: tuple[str, ...], listing: bool, out: str | None, prints: Prints,
            as_json: bool) -> None:  # fmt: skip
    """Draw the paper's figures and ours, all or those named, as PNG, PDF and SVG; each is computed now.

    An arm of several sections has figures of its own: slices of its workspace, how often and how well a place is
    reached, and the poses that reach one point.

    \b
    contarm figures --list
    contarm figures
    contarm figures lengths possibility --figures pdf --links 48
    contarm figures --arm two.toml slices elbow
    """
    from contarm_sim.cli.terminal import say, table, track
    from contarm_sim.view.figures import FIGURES, figures_of, left_out
    from contarm_sim.view.report.output import OutputFolder, check_output, default_folder, to_json
    from contarm_sim.view.style import save

    known, missing = figures_of(arm), left_out(arm)
    if listing:
        if as_json:
            click.echo(to_json({name: meaning for name, (meaning, _) in known.items()}))
        else:
            table("figures", ["name", "shows"], [[name, meaning] for name, (meaning, _) in known.items()])
        return
    for name in names:
        if name in missing:
            raise InputError("name", repr(name), f"for {missing[name]}; of this arm: {', '.join(known)}")
        if name not in known:
            raise InputError("name", repr(name), ", ".join(known))
    chosen = names or tuple(known)
    target = Path(out) if out is not None else default_folder("figures")
    check_output(target)
    with OutputFolder(target) as opened:
        for i in track(range(len(chosen)), "figures"):
            draw = known[chosen[i]][1]
            save(opened.folder, chosen[i], lambda sheet, draw=draw: draw(sheet, arm), prints)  # type: ignore[misc]
    files = [str(opened.target / file) for name in chosen for file in prints.all_names(name)]
    click.echo(to_json({"files": files}) if as_json else "\n".join(files))
    say(f"written: {opened.target}")
    if not names and len(arm.sections) == 1:
        for name in missing.keys() & FIGURES.keys():
            say(f"left out: {name}, which needs {missing[name]}")

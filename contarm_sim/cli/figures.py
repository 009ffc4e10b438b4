"""`contarm figures`: the paper's figures and ours, computed and drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import ANGLE, TIME, Command, arm_options, json_option, out_option
from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.view.prints import Prints


@click.command(cls=Command)
@click.argument("names", nargs=-1, metavar="[NAME ...]")
@click.option("--list", "listing", is_flag=True, help="Name the figures and what they show.")
@click.option(
    "--path", "path_name", metavar="NAME|FILE.csv",
    help="What the figures of a motion follow, as in contarm run; default the paper's spiral.",
)  # fmt: skip
@click.option("--duration", type=TIME, metavar="S", help="Time for the path [s]; default 10, or what the file says.")
@click.option("--max-bend", type=ANGLE, metavar="X", help="Largest bend angle on the path [rad]; default 120deg.")
@click.option(
    "--project", type=click.Choice(["refuse", "nearest", "ray", "paper"]),
    help="What to do with targets off the dome (see contarm ik --help); default refuse.",
)  # fmt: skip
@out_option("runs/figures-<time>")
@figure_options("png,pdf,svg")
@json_option
@arm_options
def figures(arm: Arm, names: tuple[str, ...], listing: bool, path_name: str | None, duration: float | None,
            max_bend: float | None, project: Any, out: str | None, prints: Prints, as_json: bool) -> None:  # fmt: skip
    """Draw the paper's figures and ours, all or those named, as PNG, PDF and SVG; each is computed now.

    They show the arm as it is, with its gravity and payload. An arm of several sections has figures of its own: slices
    of its workspace, how often and how well a place is reached, and the poses that reach one point. With a path of
    one's own, and no names, those of a motion are drawn.

    \b
    contarm figures --list
    contarm figures
    contarm figures lengths possibility --figures pdf --links 48
    contarm figures --arm two.toml slices elbow
    contarm figures --arm mine.toml --path circle --max-bend 60deg
    """
    from contarm_sim.cli.terminal import say, table, track
    from contarm_sim.view.figures import FIGURES, FOLLOWING, figures_of, left_out
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
    own = _own_path(arm, path_name, duration, max_bend, project)
    chosen = names or tuple(name for name in known if own is None or name in FOLLOWING)
    target = Path(out) if out is not None else default_folder("figures")
    check_output(target)
    with OutputFolder(target) as opened:
        for i in track(range(len(chosen)), "figures"):
            draw = known[chosen[i]][1]
            save(opened.folder, chosen[i], lambda sheet, draw=draw: draw(sheet, arm, own), prints)  # type: ignore[misc]
    files = [str(opened.target / file) for name in chosen for file in prints.all_names(name)]
    click.echo(to_json({"files": files}) if as_json else "\n".join(files))
    say(f"written: {opened.target}")
    if not names and own is None and len(arm.sections) == 1:
        for name in (name for name in FIGURES if name in missing):
            say(f"left out: {name}, which needs {missing[name]}")


def _own_path(arm: Arm, name: str | None, duration: float | None, max_bend: float | None, project: Any) -> Any:
    """Return what the figures of a motion follow, or None for the paper's spiral in ten seconds.

    Raises:
        InputError: a path that there is not, or that the tip cannot follow.
    """
    if name is None and duration is None and max_bend is None and project is None:
        return None
    from contarm_sim import paths
    from contarm_sim.cli.path import path_of, reference_of
    from contarm_sim.cli.terminal import say
    from contarm_sim.view.figures.common import OwnPath

    name = "spiral" if name is None else name
    path, waypoints = path_of(arm, name, duration, {} if max_bend is None else {"max_bend": max_bend})
    reference = reference_of(arm, path, project or "refuse", None if waypoints is None else waypoints.places)
    for note in () if waypoints is None else waypoints.notes:
        say(note)
    return OwnPath(f"the {name}" if name in paths.NAMES else f"the path of {Path(name).name}", reference)

"""`contarm demo`: what arms do with what they touch, each shown, measured and checked."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.options import Command, json_option, out_option
from contarm_sim.view.prints import PLAIN

NAMES = ("grasp", "reach-around", "lean")

_SHOWN = {"m": (1e3, "mm"), "rad": (180 / math.pi, "deg"), "": (1.0, "x")}


@click.command(cls=Command)
@click.argument("name", metavar="|".join(NAMES), type=click.Choice(NAMES))
@click.option("--no-video", is_flag=True, help="Numbers and a figure only.")
@out_option("runs/demo-NAME-<time>")
@json_option
def demo(name: str, no_video: bool, out: str | None, as_json: bool) -> int:
    """Simulate an arm that touches things, film it, and check what it does.

    \b
    grasp         a hanging arm curls round a log, lifts it off its forks and puts it down
    reach-around  the tip comes to a point behind a post; plain inverse kinematics hits the post
    lean          the arm leans on a wall, and its tip is stiffer for it

    Leaves summary.json, trajectory.npz, contacts.csv, arm.toml, arm.xml, contact.png (of a motion that touches
    something) and video.mp4; contarm render draws other films of it. The motion that it is compared with is in
    beside/. Exit code 1 if a check fails. Numbers are on disk before anything is drawn; Ctrl-C before that leaves
    nothing.

    \b
    contarm demo grasp
    contarm demo reach-around --no-video --json
    """
    from importlib import import_module

    from contarm_sim.cli.drawing import say_missing
    from contarm_sim.cli.study import output_for
    from contarm_sim.cli.terminal import command_line, progress, say
    from contarm_sim.stopping import exit_code
    from contarm_sim.versions import versions
    from contarm_sim.view.report.output import OutputFolder, to_json
    from contarm_sim.view.report.run_files import write_run

    target = output_for(out, f"demo-{name}")
    module = import_module(f"contarm_sim.demos.{name.replace('-', '_')}")
    with progress("simulating") as show:
        found = module.demonstrate(show)
    summary: dict[str, Any] = {
        "demo": name,
        "said": found.said,
        "checks": [vars(check) | {"passed": check.passed} for check in found.checks],
        "verdict": "pass" if found.passed else "fail",
        "timestep": found.run.timestep,
        "command": command_line(),
        "versions": versions(),
    }
    with OutputFolder(target) as opened:
        write_run(opened.folder, found.run)
        if found.beside is not None:
            (opened.folder / "beside").mkdir()
            write_run(opened.folder / "beside", found.beside)
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
    if as_json:
        click.echo(to_json(summary))
    else:
        _show(name, found)
    missing = _missing(opened.target, found, not no_video)
    say(f"written: {opened.target}")
    if missing:
        say_missing(missing, f"contarm render {opened.target}")
        return exit_code()
    return 0 if found.passed else 1


def _missing(folder: Path, found: Any, filmed: bool) -> list[str]:
    """Draw and film; return what an interruption left out."""
    from contarm_sim.stopping import came

    try:
        _draw(folder, found)
        if filmed:
            _film(folder, found)
    except KeyboardInterrupt:
        pass
    else:
        if came() is None:  # else a library may have made a failure of the interruption
            return []
    wanted = [*(str(place / "contact.png") for _, place in _touching(found)), *(("video.mp4",) if filmed else ())]
    return [name for name in wanted if not (folder / name).is_file()]


def _touching(found: Any) -> list[tuple[Any, Path]]:
    """Return the motions that touch something, and where they lie in the folder."""
    both = ((found.run, Path()), (found.beside, Path("beside")))
    return [(run, place) for run, place in both if run is not None and run.contacts]


def _draw(folder: Path, found: Any) -> None:
    """Draw what the arm touches: forces, depths and links over time, of each motion that touches anything."""
    from contarm_sim.cli.drawing import MACHINE
    from contarm_sim.cli.terminal import say
    from contarm_sim.view.report.contact_figure import draw_contact
    from contarm_sim.view.style import save

    for run, place in _touching(found):
        try:
            save(folder / place, "contact", partial(draw_contact, samples=run), PLAIN)
        except MACHINE as error:
            say(f"no contact.png: {error}")


def _film(folder: Path, found: Any) -> None:
    """Film both motions side by side; nothing is lost for want of a film."""
    from contarm_sim.cli.drawing import MACHINE, say_backend
    from contarm_sim.cli.terminal import progress, say
    from contarm_sim.view.rendering.video import write_video

    try:
        with progress("filming") as on_frame:
            write_video(shot(found), folder / "video.mp4", on_frame)
        say_backend()
    except MACHINE as error:
        say(f"no video: {error}")


def shot(
    found: Any, size: tuple[int, int] = (0, 0), fps: float = 30.0, speed: float = 1.0, letters: float = 0.024
) -> Any:
    """Return what a film of a demonstration shows: the arm, what it touches, and the forces on it.

    Args:
        size: width and height [pixels]; default the demonstration's own.
        letters: their size, in heights of the picture.
    """
    from contarm_sim.view.rendering.draw import Overlays
    from contarm_sim.view.rendering.look import Look
    from contarm_sim.view.rendering.video import Shot

    overlays = Overlays(path=False, trace=False, target=found.aims, ghost=False, frames=False)
    width, height = size if all(size) else found.size
    look = Look(width, height, found.camera, plots=False, overlays=overlays, letters=letters)
    return Shot(found.run, look, fps, speed, found.beside, found.names)


def _show(name: str, found: Any) -> None:
    from contarm_sim.cli.terminal import table

    rows = []
    for check in found.checks:
        factor, unit = _SHOWN.get(check.unit, (1.0, check.unit))
        allowed = f"at {'least' if check.least else 'most'} {factor * check.limit:g} {unit}".rstrip()
        measured = f"{factor * check.value:.3g} {unit}".rstrip()
        rows.append([check.what, measured, allowed, "yes" if check.passed else "NO"])
    table(f"demo {name}", ["", "measured", "allowed", "holds"], rows)
    click.echo(f"{found.said}.")
    click.echo(f"verdict: {'PASS' if found.passed else 'FAIL'}")

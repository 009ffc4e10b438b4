"""`contarm ik`: bends that reach tip positions, directions or poses, on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from contarm_sim.cli.options import ANGLE, LENGTH, PLAIN, Command, arm_options, json_option
from contarm_sim.errors import InputError, UnreachableError
from contarm_sim.model.arm import Arm

if TYPE_CHECKING:
    from contarm_sim.paths.targets import Targets

CHOICES = ("least-bend", "least-largest", "farthest", "nearest", "all")


@click.command(cls=Command)
@click.option("--tip", type=LENGTH, nargs=3, metavar="X Y Z", help="Target of the tip in the base frame [m].")
@click.option(
    "--direction", type=PLAIN, nargs=3, metavar="X Y Z", help="Direction of the tip, its +Z, of any length but 0."
)
@click.option("--quaternion", type=PLAIN, nargs=4, metavar="W X Y Z", help="Orientation of the tip.")
@click.option(
    "--file", metavar="TARGETS.csv",
    help="Targets: a CSV file with columns x,y,z (t,x,y,z) [m], and perhaps dx,dy,dz or qw,qx,qy,qz.",
)  # fmt: skip
@click.option(
    "--choose", type=click.Choice(CHOICES),
    help="Which solution of several sections: least sum of bends (default), least largest bend, farthest from the "
    "limits, nearest to --from, or all.",
)  # fmt: skip
@click.option(
    "--from", "near", type=ANGLE, nargs=2, multiple=True, metavar="BEND_ANGLE PLANE_ANGLE",
    help="Pose to be nearest to [rad]; once for each section.",
)  # fmt: skip
@click.option(
    "--limit", type=ANGLE, multiple=True, metavar="X",
    help="Largest bend angle [rad], once for all sections or for each; default what the lengths of muscles "
    "that run in one section alone allow.",
)  # fmt: skip
@click.option("--out", metavar="SOLUTIONS.csv", help="Write the solutions to a CSV file that does not exist yet.")
@click.option(
    "--project", default="refuse", type=click.Choice(["refuse", "nearest", "ray", "paper"]), show_default=True,
    help="A target out of reach: refuse it, take the nearest point; of one section also keep its direction (ray), or "
    "trust the paper. Of one section, and of two with a direction, the nearest keeps the position first.",
)  # fmt: skip
@click.option(
    "--tolerance", type=LENGTH, metavar="X",
    help="Largest miss that counts as reached [m]; default 3e-4 length. Angles count as their arc at 0.3 length.",
)  # fmt: skip
@click.option(
    "--avoid", is_flag=True, help="Keep the whole arm clear of the objects of its world ([[object]] in TOML)."
)
@click.option(
    "--margin", type=LENGTH, metavar="X",
    help="Clearance to keep from the objects [m], with --avoid; default 2.5 % of the arm's length.",
)  # fmt: skip
@click.option(
    "--figure",
    metavar="FILE",
    help="Draw the poses that reach --tip, blocked and clear: .png, .pdf, .svg; with --avoid.",
)
@json_option
@arm_options
def ik(
    arm: Arm, tip: Any, direction: Any, quaternion: Any, file: str | None, choose: str | None, near: Any,
    limit: tuple[float, ...], out: str | None, project: Any, tolerance: float | None, avoid: bool,
    margin: float | None, figure: str | None, as_json: bool,
) -> None:  # fmt: skip
    """Inverse kinematics: tip positions to bends and muscle lengths.

    The tips that one section reaches form a surface (a dome), those of more sections a volume; every solution reports
    its miss. Two sections reach a point by a whole family of bends, three a full pose by a few.

    \b
    contarm ik --tip 0.2355 0 0.2355
    contarm ik --tip 0.1 0.1 0.3 --project nearest --json
    contarm ik --file targets.csv --out solutions.csv
    contarm ik --preset two --tip 0.1 0.05 0.3 --choose all
    contarm ik --preset three --tip 0.2 0.1 0.4 --direction 1 0 0
    contarm ik --arm examples/post.toml --tip 0.2 0.06 0.25 --avoid --figure around.png
    """
    from contarm_sim.cli.avoiding import check_flags, draw
    from contarm_sim.cli.solutions import show, show_all, write
    from contarm_sim.cli.solving import Asked, solved
    from contarm_sim.cli.terminal import say, say_objects
    from contarm_sim.view.report.output import check_output, to_json

    if (tip is None) == (file is None):
        raise InputError("input", "both --tip and --file" if tip else "neither --tip nor --file", "one of them")
    if tolerance is not None and not tolerance >= 0:
        raise InputError("tolerance", tolerance, "a number of at least 0 [m]")
    check_flags(avoid, margin, figure, choose, project)
    for path in (out, figure):
        if path is not None:
            check_output(Path(path))
    if not avoid:
        say_objects(arm, "--avoid keeps clear of them" if arm.world.objects else "")
    targets = _targets(tip, direction, quaternion, file)
    if figure is not None and file is not None:
        raise InputError("--figure", "given with --file", "one target: --tip")
    asked = Asked(choose, near, limit, project, tolerance, avoid, margin)
    try:
        solutions, found = solved(arm, targets, asked)
    except UnreachableError as error:
        raise asking(error, arm).located(targets.place(error.index)) from None
    for note in targets.notes:
        say(note)
    if out is not None:
        write(Path(out), arm, solutions)
        say(f"written: {out}")
    if figure is not None:
        draw(Path(figure), arm, targets, found[0])
        say(f"written: {figure}")
    if as_json:
        click.echo(to_json([{key: value for key, value in row.items() if key != "asks_turn"} for row in solutions]))
    elif tip is not None and len(solutions) == 1:
        show(arm, solutions[0], [("tip", solutions[0]["transform"])])
    elif out is not None:
        if choose == "all":
            click.echo(f"{len(solutions)} solutions written")
            return
        worst, reached = max(row["miss"] for row in solutions), sum(row["reachable"] for row in solutions)
        off = f", {len(solutions) - reached} out of reach projected" if reached < len(solutions) else ""
        click.echo(f"{reached} target{'s' * (reached != 1)} solved{off}; the largest miss is {1e3 * worst:.4g} mm")
    else:
        show_all(arm, solutions)


def _targets(tip: Any, direction: Any, quaternion: Any, file: str | None) -> Targets:
    """Return the targets of the flags or of a file."""
    from contarm_sim.paths.targets import of_numbers, read_targets

    if file is None:
        return of_numbers(tip, direction, quaternion)
    if direction is not None or quaternion is not None:
        name = "direction" if direction is not None else "quaternion"
        raise InputError(f"--{name}", "given with --file", "columns dx,dy,dz or qw,qx,qy,qz of the file")
    return read_targets(file)


def asking(error: UnreachableError, arm: Arm) -> UnreachableError:
    """Return an error, with a question where a target in millimetres explains it: a thousandth lies within reach."""
    import numpy as np

    from contarm_sim.kinematics import dome

    near = 1e-3 * np.asarray(error.target)
    within = np.linalg.norm(near) <= arm.length if len(arm.sections) > 1 else (
        dome.bend_from_tip(near, arm.length, "nearest").miss <= 0.1 * arm.length
    )  # fmt: skip
    return error.asking("in millimetres?") if within and error.miss > arm.length else error

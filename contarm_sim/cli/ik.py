"""`contarm ik`: bends that reach tip positions, directions or poses, on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from contarm_sim.cli.options import ANGLE, LENGTH, PLAIN, Command, arm_options, bends_from_words, json_option
from contarm_sim.errors import InputError, UnreachableError
from contarm_sim.model.arm import Arm

if TYPE_CHECKING:
    from contarm_sim.kinematics.backbone import Backbone
    from contarm_sim.paths.targets import Targets
    from contarm_sim.planning import Avoiding

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
    contarm ik --arm examples/post.toml --tip 0.2 0.08 0.15 --avoid --figure around.png
    """
    from contarm_sim.cli.avoiding import check_flags, draw
    from contarm_sim.cli.solutions import show, show_all, write
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
    asked = _Asked(choose, near, limit, project, tolerance, avoid, margin)
    try:
        solutions, found = _solved(arm, targets, asked)
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


@dataclass(frozen=True)
class _Asked:
    """How targets are to be solved, as the flags say it."""

    choose: str | None
    near: tuple[tuple[float, float], ...]
    limit: tuple[float, ...]
    project: Any
    tolerance: float | None
    avoid: bool
    margin: float | None


def _targets(tip: Any, direction: Any, quaternion: Any, file: str | None) -> Targets:
    """Return the targets of the flags or of a file."""
    from contarm_sim.paths.targets import of_numbers, read_targets

    if file is None:
        return of_numbers(tip, direction, quaternion)
    if direction is not None or quaternion is not None:
        name = "direction" if direction is not None else "quaternion"
        raise InputError(f"--{name}", "given with --file", "columns dx,dy,dz or qw,qx,qy,qz of the file")
    return read_targets(file)


def _solved(arm: Arm, targets: Targets, asked: _Asked) -> tuple[list[dict[str, Any]], list[Avoiding]]:
    """Return what is said of each solution, and those that avoid as they are.

    Raises:
        UnreachableError: a target out of reach, unless projected.
        BlockedError: a target without a clear pose, where that is asked for.
        InputError: flags that do not suit this arm.
    """
    from contarm_sim.kinematics import inverse
    from contarm_sim.mechanics import shape

    plain = not (targets.turned or asked.choose or asked.near or asked.limit or asked.avoid)
    if len(arm.sections) == 1 and plain:
        return _on_dome(arm, targets, asked), []
    if asked.project not in ("refuse", "nearest"):
        allowed = "refuse or nearest; ray and paper are for positions of one section alone"
        raise InputError("--project", asked.project, allowed)
    _check_limits(asked.limit, arm)
    form = shape.backbone(arm, limits=asked.limit or None)
    if asked.near and asked.choose not in (None, "nearest"):
        raise InputError("--from", f"given with --choose {asked.choose}", "--choose nearest, or no --choose")
    if asked.choose == "all":
        return _all(arm, targets, form, asked), []
    near = bends_from_words(asked.near, arm, "from").reshape(-1, 2) if asked.near else None
    choose: Any = asked.choose or ("nearest" if asked.near else "least-bend")
    if choose == "nearest" and near is None:
        raise InputError("--choose nearest", "given without --from", "--from BEND_ANGLE PLANE_ANGLE for each section")
    if asked.avoid:
        return _avoided(arm, targets, asked, choose, near)
    found = inverse.solve(targets.position, form, targets.direction, targets.rotation, choose, near)
    return _said(arm, targets, found.bends, found.solutions, asked, form.limits), []


def _avoided(
    arm: Arm, targets: Targets, asked: _Asked, choose: Any, near: Any
) -> tuple[list[dict[str, Any]], list[Avoiding]]:
    """Return the same of poses that keep clear of objects."""
    import numpy as np

    from contarm_sim.cli.avoiding import avoided, said_of

    limits = asked.limit or None
    found = avoided(arm, targets, asked.margin, choose, near, limits)
    bends = np.stack([each.bends for each in found])
    count = np.array([each.solutions for each in found])
    rows = _said(arm, targets, bends, count, asked, limits or ())
    return [row | said_of(each) for row, each in zip(rows, found, strict=True)], found


def _check_limits(limits: tuple[float, ...], arm: Arm) -> None:
    """Refuse limits that are none, or not one for all sections or for each.

    Raises:
        InputError: says which.
    """
    import math

    count = len(arm.sections)
    if len(limits) not in (0, 1, count):
        raise InputError("--limit", f"given {len(limits)} times", f"once, or {count} times, once for each section")
    for limit in limits:
        if not 0 < limit < math.pi:
            given = f"{limit:.6g} rad ({math.degrees(limit):.6g} deg)"
            raise InputError("--limit", given, "above 0, below pi rad (180 deg)")


def _all(arm: Arm, targets: Targets, form: Backbone, asked: _Asked) -> list[dict[str, Any]]:
    import numpy as np

    from contarm_sim.kinematics import inverse

    if len(targets.position) != 1:
        raise InputError("--choose all", f"given for {len(targets.position)} targets", "one target: --tip")
    one = targets.repeated(1)
    direction, rotation = (None if each is None else each[0] for each in (one.direction, one.rotation))
    pieces = inverse.solve_all(one.position[0], form, direction, rotation)
    if not pieces:
        found = inverse.solve(one.position, form, one.direction, one.rotation)
        return _said(arm, targets, found.bends, found.solutions, asked, form.limits)
    bends = np.concatenate(pieces)
    isolated = all(len(piece) == 1 for piece in pieces)
    count = np.full(len(bends), len(bends) if isolated else -1)
    rows = _said(arm, targets.repeated(len(bends)), bends, count, asked, form.limits)
    for row, piece in zip(rows, np.repeat(np.arange(1, len(pieces) + 1), [len(p) for p in pieces]), strict=True):
        row["piece"] = int(piece)
    return rows


def _said(
    arm: Arm, targets: Targets, bends: Any, count: Any, asked: _Asked, limits: tuple[float, ...]
) -> list[dict[str, Any]]:
    """Return what is said of solutions, shape (T, S, 2), if they reach their targets or may miss them.

    Raises:
        UnreachableError: the first that does not, unless projected.
    """
    import numpy as np

    from contarm_sim.cli.solutions import of_bends
    from contarm_sim.kinematics.dome import TOLERANCE
    from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH
    from contarm_sim.mechanics import shape

    bend = bends.reshape(len(bends), -1)
    tips = shape.transform(bend, arm)
    miss, angle = targets.misses(tips)
    tolerance = TOLERANCE * arm.length if asked.tolerance is None else asked.tolerance
    reached = np.maximum(miss, ANGLE_LENGTH * arm.length * angle) <= tolerance
    if asked.project == "refuse" and not reached.all():
        index = int(np.argmin(reached))
        raise UnreachableError(
            targets.position[index], float(miss[index]), tips[index, :3, 3], tolerance, index,
            angle=float(angle[index]), dome=False, limits=limits,
        )  # fmt: skip
    rows = of_bends(arm, bend)
    return [
        {
            "target": targets.position[i].tolist(), "miss": float(miss[i]), "angle_miss": float(angle[i]),
            "reachable": bool(reached[i]), "solutions": int(count[i]), "bends": bends[i].tolist(), **rows[i],
            "transform": tips[i].tolist(), "asks_turn": targets.turned,
        }
        for i in range(len(bends))
    ]  # fmt: skip


def _on_dome(arm: Arm, targets: Targets, asked: _Asked) -> list[dict[str, Any]]:
    """Return the same of one section and positions alone, by the dome and its projections."""
    from contarm_sim.cli.solutions import of_bends
    from contarm_sim.kinematics import arc, dome

    reach = dome.bend_from_tip(targets.position, arm.length, asked.project, asked.tolerance)
    reached, solved = arc.transform(reach.bend, arm.length), of_bends(arm, reach.bend)
    return [
        {
            "target": targets.position[i].tolist(), "miss": float(reach.miss[i]), "angle_miss": 0.0,
            "reachable": bool(reach.reachable[i]), "solutions": int(reach.reachable[i]),
            "bends": [reach.bend[i].tolist()], **solved[i], "transform": reached[i].tolist(),
        }
        for i in range(len(solved))
    ]  # fmt: skip


def asking(error: UnreachableError, arm: Arm) -> UnreachableError:
    """Return an error, with a question where a target in millimetres explains it: a thousandth lies within reach."""
    import numpy as np

    from contarm_sim.kinematics import dome

    near = 1e-3 * np.asarray(error.target)
    within = np.linalg.norm(near) <= arm.length if len(arm.sections) > 1 else (
        dome.bend_from_tip(near, arm.length, "nearest").miss <= 0.1 * arm.length
    )  # fmt: skip
    return error.asking("in millimetres?") if within and error.miss > arm.length else error

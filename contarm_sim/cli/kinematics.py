"""`contarm fk` and `contarm ik`: the closed forms on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.options import ANGLE, LENGTH, PLAIN, Command, arm_options, json_option
from contarm_sim.errors import InputError, UnreachableError
from contarm_sim.model.arm import Arm

DELTA_TOLERANCE = 1e-6
"""Largest mean of muscle length changes that is taken for rounding [m]."""


@click.command(cls=Command)
@click.option(
    "--deltas", type=LENGTH, nargs=3, metavar="L1 L2 L3", help="Muscle length changes [m], shortening < 0; sum 0."
)
@click.option("--bend", type=ANGLE, nargs=2, metavar="BEND_ANGLE PLANE_ANGLE", help="Bend in polar form [rad].")
@click.option(
    "--xi", type=PLAIN, multiple=True, metavar="X ...", help="Normalised arc lengths, 0 base to 1 tip; default the tip."
)
@json_option
@arm_options
def fk(arm: Arm, deltas: Any, bend: Any, xi: tuple[float, ...], as_json: bool) -> None:
    """Forward kinematics: muscle length changes or a bend to the pose of the arc.

    \b
    contarm fk --bend 90deg 0
    contarm fk --deltas -0.02827 0.01414 0.01413 --xi 0 0.5 1 --json
    """
    import numpy as np

    from contarm_sim.kinematics import arc, muscles

    if (deltas is None) == (bend is None):
        raise InputError(
            "input", "both" if deltas else "neither of --deltas and --bend", "just one of --deltas, --bend"
        )
    if deltas is not None:
        vector, _ = muscles.bend_from_deltas(deltas, arm.muscle_radius, DELTA_TOLERANCE)
    else:
        vector = arc.from_polar(*bend)
    stations = np.array(xi) if xi else np.array(1.0)
    solution = {**_solutions(arm, vector[None])[0], "transform": arc.transform(vector, arm.length, stations).tolist()}
    if xi:
        solution["xi"] = list(xi)
    if as_json:
        from contarm_sim.view.report.output import to_json

        click.echo(to_json(solution))
    else:
        _show(
            solution,
            [
                (f"xi = {x:g}", T)
                for x, T in zip(xi or (1.0,), np.reshape(solution["transform"], (-1, 4, 4)), strict=True)
            ],
        )


@click.command(cls=Command)
@click.option("--tip", type=LENGTH, nargs=3, metavar="X Y Z", help="Target of the tip in the base frame [m].")
@click.option("--file", metavar="TARGETS.csv", help="Targets: a CSV file with columns x,y,z (t,x,y,z) [m].")
@click.option("--out", metavar="SOLUTIONS.csv", help="Write the solutions to a CSV file that does not exist yet.")
@click.option(
    "--project",
    default="refuse",
    type=click.Choice(["refuse", "nearest", "ray", "paper"]),
    help="A target off the dome: refuse it, take the dome's nearest point, keep its direction, or trust the paper.",
    show_default=True,
)
@click.option(
    "--tolerance", type=LENGTH, metavar="X", help="Largest miss that counts as reached [m]; default 3e-4 length."
)
@json_option
@arm_options
def ik(
    arm: Arm, tip: Any, file: str | None, out: str | None, project: Any, tolerance: float | None, as_json: bool
) -> None:
    """Inverse kinematics: tip positions to bends and muscle lengths.

    The reachable tips form a surface (a dome), so every solution reports its miss.

    \b
    contarm ik --tip 0.2355 0 0.2355
    contarm ik --tip 0.1 0.1 0.3 --project nearest --json
    contarm ik --file targets.csv --out solutions.csv
    """
    import numpy as np

    from contarm_sim.cli.terminal import say
    from contarm_sim.kinematics import arc, dome
    from contarm_sim.view.report.output import check_output, to_json

    if (tip is None) == (file is None):
        raise InputError("input", "both" if tip else "neither of --tip and --file", "just one of --tip, --file")
    if tolerance is not None and not tolerance >= 0:
        raise InputError("tolerance", tolerance, "a number of at least 0 [m]")
    if out is not None:
        check_output(Path(out))
    targets, places, notes = _targets(tip, file)
    try:
        reach = dome.bend_from_tip(targets, arm.length, project, tolerance)
    except UnreachableError as error:
        raise asking(error, arm).located(None if places is None else places[error.index]) from None
    for note in notes:
        say(note)
    reached, solved = arc.transform(reach.bend, arm.length), _solutions(arm, reach.bend)
    solutions = [
        {
            "target": targets[i].tolist(),
            "miss": float(reach.miss[i]),
            "reachable": bool(reach.reachable[i]),
            **solved[i],
            "transform": reached[i].tolist(),
        }
        for i in range(len(targets))
    ]
    if out is not None:
        _write(Path(out), solutions)
        say(f"written: {out}")
    if as_json:
        click.echo(to_json(solutions))
    elif tip is not None:
        _show(solutions[0], [("tip", np.array(solutions[0]["transform"]))])
    elif out is not None:
        worst = max(row["miss"] for row in solutions)
        click.echo(f"{len(solutions)} targets solved; the largest miss is {1e3 * worst:.4g} mm")
    else:
        from contarm_sim.cli.terminal import table

        table(
            f"{len(solutions)} targets",
            ["target x y z [mm]", "bend [deg]", "plane [deg]", "l1 [mm]", "l2 [mm]", "l3 [mm]", "miss [mm]"],
            [
                [
                    " ".join(f"{1e3 * x:.2f}" for x in row["target"]),
                    f"{np.degrees(row['bend_angle']):.3f}",
                    f"{np.degrees(row['plane_angle']):.2f}",
                    *(f"{1e3 * x:.3f}" for x in row["muscle_deltas"]),
                    f"{1e3 * row['miss']:.4f}",
                ]
                for row in solutions[:200]
            ],
            caption=f"the first 200 of {len(solutions)}; --out writes all" if len(solutions) > 200 else None,
        )


def asking(error: UnreachableError, arm: Arm) -> UnreachableError:
    """Return an error, with a question where a target in millimetres explains it: a thousandth lies near the dome."""
    import numpy as np

    from contarm_sim.kinematics import dome

    near = dome.bend_from_tip(1e-3 * np.asarray(error.target), arm.length, "nearest").miss <= 0.1 * arm.length
    return error.asking("in millimetres?") if near and error.miss > arm.length else error


def _targets(tip: Any, file: str | None) -> tuple[Any, list[str] | None, tuple[str, ...]]:
    """Return (targets [m], their places in a file, what to say of the file)."""
    import numpy as np

    if file is None:
        return np.array([tip]), None, ()
    from contarm_sim.paths.waypoints import read_csv

    waypoints = read_csv(file)
    return waypoints.positions, waypoints.places, waypoints.notes


def _solutions(arm: Arm, bends: Any) -> list[dict[str, Any]]:
    """Return what is said of each bend [rad], shape (T, 2): computed for all at once."""
    from contarm_sim.kinematics import arc, muscles

    angle, plane = arc.to_polar(bends)
    deltas = muscles.deltas_from_bend(bends, arm.muscle_radius)
    columns = {
        "bend_angle": angle,
        "plane_angle": plane,
        "curvature": angle / arm.length,
        "muscle_deltas": deltas,
        "muscle_lengths": arm.length + deltas,
        "tip": arc.position(bends, arm.length),
    }
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def _show(solution: dict[str, Any], frames: list[tuple[str, Any]]) -> None:
    import math

    def mm(values: list[float]) -> str:
        return "  ".join(f"{1e3 * x + 0.0:.4f}" for x in values)

    rows = [
        ("bend angle", f"{math.degrees(solution['bend_angle']):.4f} deg"),
        ("bending plane", f"{math.degrees(solution['plane_angle']):.4f} deg"),
        ("curvature", f"{solution['curvature']:.5g} 1/m"),
        ("muscle length changes", mm(solution["muscle_deltas"]) + " mm"),
        ("muscle lengths", mm(solution["muscle_lengths"]) + " mm"),
        ("tip", mm(solution["tip"]) + " mm"),
    ]
    if "miss" in solution:
        off = "" if solution["reachable"] else "  (off the dome)"
        rows += [("target", mm(solution["target"]) + " mm"), ("miss", f"{1e3 * solution['miss']:.4g} mm{off}")]
    for name, frame in frames:
        for i, line in enumerate(frame):
            rows.append((f"frame at {name} [m]" if i == 0 else "", "  ".join(f"{x + 0.0: .6f}" for x in line)))
    for label, text in rows:
        click.echo(f"{label:24} {text}".rstrip())


def _write(out: Path, solutions: list[dict[str, Any]]) -> None:
    import csv

    from contarm_sim.view.report.output import output_file

    header = ["target_x_m", "target_y_m", "target_z_m", "bend_angle_rad", "plane_angle_rad", "curvature_1_per_m"]
    muscles = range(1, len(solutions[0]["muscle_deltas"]) + 1)
    header += [f"l{i}_m" for i in muscles] + [f"tip_{a}_m" for a in "xyz"] + ["miss_m", "reachable"]
    with output_file(out) as scratch, scratch.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        for row in solutions:
            values = [*row["target"], row["bend_angle"], row["plane_angle"], row["curvature"]]
            values += [*row["muscle_deltas"], *row["tip"], row["miss"]]
            writer.writerow([*map(repr, values), row["reachable"]])

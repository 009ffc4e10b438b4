"""What `contarm fk` and `contarm ik` say of bends: as documents, for people, and as CSV."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.avoiding import clearance_words
from contarm_sim.model.arm import Arm

ROUNDING = 1e-9
"""Distance [mm] or angle [deg] that is put down to rounding."""


def of_bends(arm: Arm, bend: Any) -> list[dict[str, Any]]:
    """Return what is said of each of many bends [rad], shape (T, 2 S): computed for all at once.

    Of several sections, bend angle, plane angle and curvature are lists.
    """
    import numpy as np

    from contarm_sim.kinematics import arc
    from contarm_sim.mechanics import routing, shape
    from contarm_sim.mechanics.muscles import each

    angle, plane = arc.to_polar(shape.bends_of(bend, arm))
    curvature = angle / np.array([section.length for section in arm.sections])
    if len(arm.sections) == 1:
        angle, plane, curvature = angle[:, 0], plane[:, 0], curvature[:, 0]
    deltas = routing.arc_deltas(bend, arm) if arm.groups else np.empty((len(bend), 0))
    columns = {
        "bend_angle": angle,
        "plane_angle": plane,
        "curvature": curvature,
        "muscle_deltas": deltas,
        "muscle_lengths": each(arm, lambda group: group.length) + deltas,
        "tip": shape.position(bend, arm),
    }
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def of_sections(arm: Arm, bend: Any) -> list[dict[str, Any]]:
    """Return what is said of each section at one bend [rad], shape (2 S,)."""
    from contarm_sim.kinematics import arc
    from contarm_sim.mechanics import muscles, routing, shape

    bends = shape.bends_of(bend, arm)
    angle, plane = arc.to_polar(bends)
    own = {group.section: part for group, part in zip(arm.groups, muscles.slices(arm), strict=True)}
    deltas = routing.arc_deltas(bend, arm) if arm.groups else bend[:0]
    lengths = muscles.each(arm, lambda group: group.length) + deltas
    out, passed = [], 0.0
    for number, section in enumerate(arm.sections):
        passed += section.length
        mine, last = own.get(number, slice(0, 0)), number == len(arm.sections) - 1
        out.append(
            {
                "bend": bends[number].tolist(),
                "bend_angle": float(angle[number]),
                "plane_angle": float(plane[number]),
                "muscle_deltas": deltas[mine].tolist(),
                "muscle_lengths": lengths[mine].tolist(),
                "transform": shape.transform(bend, arm, 1.0 if last else passed / arm.length).tolist(),
            }
        )
    return out


def show(arm: Arm, solution: dict[str, Any], frames: list[tuple[str, Any]]) -> None:
    """Print a solution for people, with frames [m] at places."""
    import math

    rows = _bends(solution) if len(arm.sections) == 1 else _bends_of_sections(arm, solution)
    if len(arm.sections) > 1 and (needed := _needed(arm, solution)):
        rows.append(("pressure needed", needed))
    rows.append(("tip", _mm(solution["tip"])))
    if "miss" in solution:
        beyond = "  (off the dome)" if len(arm.sections) == 1 else "  (out of reach)"
        off = "" if solution["reachable"] else beyond
        turned = solution.get("asks_turn", False)
        rows += [("target", _mm(solution["target"]))]
        rows += [("miss", f"{_left(1e3 * solution['miss'])} mm{'' if turned else off}")]
        if turned:
            rows.append(("angle off", f"{_left(math.degrees(solution['angle_miss']))} deg{off}"))
        if len(arm.sections) > 1:
            rows.append(("solutions", _counted(solution)))
        if "clearance" in solution:
            rows.append(("clearance", clearance_words(arm, solution)))
    for name, frame in frames:
        for i, line in enumerate(frame):
            rows.append(
                (f"frame at {name} [m]" if i == 0 else "", "  ".join(f"{round(float(x), 6) + 0.0: .6f}" for x in line))
            )
    for label, text in rows:
        click.echo(f"{label:24} {text}".rstrip())


def _needed(arm: Arm, solution: dict[str, Any]) -> str:
    """Return the highest of the least pressures that hold the bends, with the arm's weight; nothing if unknown."""
    import numpy as np

    from contarm_sim.errors import InputError
    from contarm_sim.kinematics import arc
    from contarm_sim.mechanics.pressures import pressure_needed

    try:
        most = min(group.pneumatics.max_pressure for group in arm.groups)
        bend = arc.from_polar(solution["bend_angle"], solution["plane_angle"]).reshape(-1)
        needed = float(pressure_needed(bend, arm)[0])
    except (InputError, ValueError):  # other laws, too few muscles, or none
        return ""
    said = f"{needed / 1e3:.0f} kPa" if np.isfinite(needed) else "more than any"
    return f"{said}; there are {most / 1e3:.0f} kPa{'' if needed <= most else ', too few to hold this'}"


def _mm(values: list[float]) -> str:
    return "  ".join(f"{round(1e3 * x, 4) + 0.0:.4f}" for x in values) + " mm"


def _plane(angle: float, digits: int) -> float:
    """Return a plane angle [deg], rounded, above -180 and up to 180."""
    import math

    degrees = round(math.degrees(angle), digits) + 0.0
    return 180.0 if degrees == -180 else degrees


def _left(size: float) -> str:
    """Return what is left of a distance [mm] or an angle [deg]; rounding is nothing."""
    return f"{size if size > ROUNDING else 0.0:.4g}"


def _bends(solution: dict[str, Any]) -> list[tuple[str, str]]:
    import math

    return [
        ("bend angle", f"{math.degrees(solution['bend_angle']):.4f} deg"),
        ("bending plane", f"{math.degrees(solution['plane_angle']):.4f} deg"),
        ("curvature", f"{solution['curvature']:.5g} 1/m"),
        ("muscle length changes", _mm(solution["muscle_deltas"])),
        ("muscle lengths", _mm(solution["muscle_lengths"])),
    ]


def _bends_of_sections(arm: Arm, solution: dict[str, Any]) -> list[tuple[str, str]]:
    import math

    from contarm_sim.mechanics import muscles

    own = {group.section: part for group, part in zip(arm.groups, muscles.slices(arm), strict=True)}
    rows = []
    for number in range(len(arm.sections)):
        angle, plane = solution["bend_angle"][number], solution["plane_angle"][number]
        said = f"bends by {math.degrees(angle):.4f} deg towards {_plane(plane, 4):.4f} deg"
        said += f", curvature {solution['curvature'][number]:.5g} 1/m"
        straight = math.degrees(angle) < 5e-5
        few = "" if arm.routings[number].count > 2 else "; its own muscles are too few to hold that"
        rows.append((f"section {number + 1}", ("straight" if straight else said) + few))
        if number in own:
            rows.append(("  muscle length changes", _mm(solution["muscle_deltas"][own[number]])))
    return rows


def _counted(solution: dict[str, Any]) -> str:
    count = solution["solutions"]
    return "a continuum; --choose all samples it" if count < 0 else str(count)


def show_all(arm: Arm, solutions: list[dict[str, Any]]) -> None:
    """Print one row a solution; of several sections, one column a section: bend angle, and the plane it bends in."""
    import numpy as np

    from contarm_sim.cli.terminal import table

    shown, listed = solutions[:200], "piece" in solutions[0]
    columns: dict[str, list[str]] = {}
    if listed:
        columns["piece"] = [str(row["piece"]) for row in shown]
    else:
        columns["target x y z [mm]"] = [" ".join(f"{1e3 * x:.2f}" for x in row["target"]) for row in shown]
    if len(arm.sections) == 1:
        columns["bend [deg]"] = [f"{np.degrees(row['bend_angle']):.3f}" for row in shown]
        columns["plane [deg]"] = [f"{np.degrees(row['plane_angle']):.2f}" for row in shown]
        for i in range(len(shown[0]["muscle_deltas"])):
            columns[f"l{i + 1} [mm]"] = [f"{1e3 * row['muscle_deltas'][i]:.3f}" for row in shown]
    else:
        for number in range(len(arm.sections)):
            bends = ((row["bend_angle"][number], row["plane_angle"][number]) for row in shown)
            columns[f"{number + 1}: bend, plane [deg]"] = [
                f"{np.degrees(angle):.2f}, {_plane(plane, 1):.1f}" for angle, plane in bends
            ]
    columns["miss [mm]"] = [f"{round(1e3 * row['miss'], 4):.4f}" for row in shown]
    if any(row.get("asks_turn") for row in shown):
        columns["angle off [deg]"] = [f"{round(np.degrees(row['angle_miss']), 4):.4f}" for row in shown]
    if "clearance" in shown[0]:
        columns["clear of"] = [f"{row['nearest_object']} by {1e3 * row['clearance']:.2f} mm" for row in shown]
    more = f"the first 200 of {len(solutions)}; --out writes all" if len(solutions) > 200 else None
    table(_title(solutions), list(columns), [list(row) for row in zip(*columns.values(), strict=True)], caption=more)


def _title(solutions: list[dict[str, Any]]) -> str:
    count = len(solutions)
    if "piece" not in solutions[0]:
        return f"{count} target{'s' * (count != 1)}"
    if solutions[0]["solutions"] >= 0:
        return f"all {count} solutions"
    pieces = len({row["piece"] for row in solutions})
    return f"a continuum of solutions in {pieces} piece{'s' * (pieces != 1)}, {count} samples of it"


def write(out: Path, arm: Arm, solutions: list[dict[str, Any]]) -> None:
    """Write solutions to a CSV file; of several sections, bends have a column for each."""
    import csv

    from contarm_sim.view.report.output import output_file

    count = len(arm.sections)
    header = ["target_x_m", "target_y_m", "target_z_m"]
    for number in range(1, count + 1):
        of = f"_{number}" if count > 1 else ""
        header += [f"bend_angle{of}_rad", f"plane_angle{of}_rad", f"curvature{of}_1_per_m"]
    muscles = range(1, len(solutions[0]["muscle_deltas"]) + 1)
    header += [f"l{i}_m" for i in muscles] + [f"tip_{a}_m" for a in "xyz"] + ["miss_m", "reachable"]
    header += ["angle_miss_rad", "solutions"] if count > 1 else []
    header += ["piece"] if "piece" in solutions[0] else []
    header += ["clearance_m", "nearest_object", "nearest_xi"] if "clearance" in solutions[0] else []
    with output_file(out) as scratch, scratch.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        for row in solutions:
            bends = [row["bend_angle"], row["plane_angle"], row["curvature"]]
            each = zip(*bends, strict=True) if count > 1 else [bends]
            values = [*row["target"], *(value for section in each for value in section)]
            values += [*row["muscle_deltas"], *row["tip"], row["miss"]]
            more = [repr(row["angle_miss"]), row["solutions"]] if count > 1 else []
            more += [row["piece"]] if "piece" in row else []
            more += (
                [repr(row["clearance"]), row["nearest_object"], repr(row["nearest_xi"])] if "clearance" in row else []
            )
            writer.writerow([*map(repr, values), row["reachable"], *more])

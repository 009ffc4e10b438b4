"""`contarm validate`: the arm at rest over the whole dome, beside the closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.options import Command, arm_options, json_option, out_option
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@click.option(
    "--grid", type=click.IntRange(2, 40), default=8, show_default=True, metavar="N",
    help="Bend angles to 170 deg; with 3 N bending planes each.",
)  # fmt: skip
@click.option("--quick", is_flag=True, help="A coarse grid (N = 3) and no figures.")
@out_option("runs/validate-<time>")
@json_option
@arm_options
def validate(arm: Arm, grid: int, quick: bool, out: str | None, as_json: bool) -> int:
    """Hold the simulated arm against the constant-curvature model, at rest, over the whole dome.

    Scenarios: no gravity (ideal), the paper's lengths in plain servos (naive), hanging (gravity), hanging with a
    payload, standing up (upright). An arm with its own gravity or payload is judged under those. Says of each whether
    constant curvature holds, which is an answer, and whether the simulation is explained: exit code 1 if it is not, or
    if a scenario has no rest pose.

    \b
    contarm validate
    contarm validate --links 48 --grid 12
    contarm validate --gravity 9.81 0 0 --bending-stiffness 0.2
    """
    from contarm_sim.cli.terminal import command_line, say, table, track
    from contarm_sim.studies.convergence import attempt_convergence
    from contarm_sim.studies.scenarios import NO_REST, Outcome, attempt, dome_grid, scenarios
    from contarm_sim.view.report.output import OutputFolder, check_output, default_folder, to_json, versions
    from contarm_sim.view.report.samples_csv import write_samples
    from contarm_sim.view.report.words import simulation_words

    target = Path(out) if out is not None else default_folder("validate")
    check_output(target)
    bends = dome_grid(3 if quick else grid)
    found = [attempt(scenario, bends, track) for scenario in scenarios(arm)]
    outcomes = [each for each in found if isinstance(each, Outcome)]
    study = attempt_convergence(arm, bends, track)
    summary = _summary(arm, found, study)
    summary |= {"versions": versions(), "command": command_line()}
    with OutputFolder(target) as out_folder:
        folder = out_folder.folder
        (folder / "summary.json").write_text(to_json(summary) + "\n")
        write_samples(folder / "samples.csv", {o.scenario.name: (o.samples, o.comparison) for o in outcomes})
        if not quick:
            from contarm_sim.view.report.figures import draw_convergence, draw_error_maps

            draw_error_maps(folder / "error_maps.png", arm, found)
            if study["verdict"] != NO_REST:
                draw_convergence(folder / "convergence.png", arm, study)
    if as_json:
        click.echo(to_json(summary))
    else:
        table(
            f"{len(bends)} poses at rest, bends to 170 deg",
            *_rows(found),
            caption="largest values; % of backbone length; open: what an ideal rod does not explain",
        )
        if study["verdict"] != NO_REST:
            steps = zip(study["links"], study["max_error_vs_arc_m"], strict=True)
            errors = ", ".join(f"{1e3 * e:.4f} mm at {n} links" for n, e in steps)
            click.echo(f"against the arc: {errors}; observed order {study['observed_orders'][-1]:.3f}")
        click.echo()
        for outcome in found:
            click.echo(_finding(outcome))
        click.echo(f"convergence: {simulation_words(study)}")
        for line in _notes(outcomes):
            click.echo(line)
    say(f"written: {out_folder.target}")
    return 0 if summary["verdict"] == "pass" else 1


def _summary(arm: Arm, outcomes: list[Any], study: dict[str, Any]) -> dict[str, Any]:
    from contarm_sim.model.arm_file import arm_to_dict
    from contarm_sim.studies.scenarios import NOT_JUDGED

    judged = [o.summary["verdict"] for o in outcomes] + [study["verdict"]]
    return {
        **{outcome.scenario.name: outcome.summary for outcome in outcomes},
        "convergence": study,
        "arm": arm_to_dict(arm),
        "verdict": "pass" if set(judged) <= {"pass", NOT_JUDGED} else "fail",
    }


def _rows(outcomes: list[Any]) -> tuple[list[str], list[list[Any]]]:
    columns = ["scenario", "tip [mm]", "[%]", "discr. [%]", "servo [%]", "shape [%]", "open [%]", "turn [deg]"]
    columns += ["force [N]", "pushes [%]"]
    rows = []
    for outcome in outcomes:
        s = outcome.summary
        if "tip_error" not in s:
            rows.append([outcome.scenario.name, "no rest", *[""] * (len(columns) - 2)])
            continue
        parts = [s[name] for name in ("tip_error", "discretisation", "servo", "shape", "unexplained")]
        percent = [None if part is None else part["max_percent"] for part in parts]
        row = [outcome.scenario.name, f"{1e3 * s['tip_error']['max_m']:.3f}"]
        row += ["not known" if x is None else f"{x:.3g}" if x >= 1 else f"{x:.4f}" for x in percent]
        muscle = s["muscle"]
        force, pushes = f"{muscle['min_force_n']:.1f} .. {muscle['max_force_n']:.1f}", 100 * muscle["push_fraction"]
        rows.append([*row, f"{s['orientation_error_deg']:.3f}", force, f"{pushes:.3g}"])
    return columns, rows


def _notes(outcomes: list[Any]) -> list[str]:
    """Say what the table does not: what the link count leaves under load, and what real muscles could not hold."""
    import numpy as np

    errors = {o.scenario.name: o.summary["link_error"] for o in outcomes if "link_error" in o.summary}
    links = ", ".join(
        f"{name} {'not known, for it does not rest' if error is None else format(error['max_percent'], '.2f') + ' %'}"
        for name, error in errors.items()
    )
    lines = [f"of which the link count, at the worst pose (estimated from twice the links): {links}"] if links else []
    blown = ", ".join(o.scenario.name for o in outcomes if o.summary["real_time_factor"] is None)
    if blown:
        lines.append(f"{blown}: stepping blows up at the default time step, so there is no real-time factor")
    for outcome in outcomes:
        beyond = outcome.summary["muscle"]["beyond_max_pressure"]
        if beyond and outcome.scenario.checks is not None:
            arm, samples = outcome.scenario.arm, outcome.samples
            pressure = samples.pressure.max(axis=1)
            over = np.hypot(*samples.bend[pressure > arm.muscle.max_pressure].T)
            first, limit = np.degrees(over.min()), arm.muscle.max_pressure / 1e3
            most, least = outcome.summary["muscle"]["max_pressure_needed_pa"], arm.muscle.min_pressure / 1e3
            needs = "more than any pressure" if most is None else f"up to {most / 1e3:.0f} kPa"
            where = f"{beyond} of {len(samples)} poses, from {first:.0f} deg on"
            there = f"available {least:.0f} to {limit:.0f} kPa"
            lines.append(f"{outcome.scenario.name}: a muscle needs {needs} ({where}); {there}")
    return lines


def _finding(outcome: Any) -> str:
    """Say of a scenario whether constant curvature holds, and whether the simulation is explained."""
    from contarm_sim.view.report.words import curvature_words, simulation_words

    summary, name = outcome.summary, outcome.scenario.name
    simulation = simulation_words(summary)
    if "constant_curvature" not in summary:
        return f"{name}: {simulation}"
    weight = summary["weight_over_stiffness"]
    mass = "(m + payload)" if summary["arm"].get("payload") else "m"
    under = f" at {mass} g L^2/EI = {weight:.2f}" if weight and not summary["constant_curvature"]["holds"] else ""
    return (
        f"{name}: constant curvature {curvature_words(summary['constant_curvature'])}{under}; simulation {simulation}"
    )
